#pragma once
// The files of the page (README.md of this folder), as the program has them: musher_embed() makes
// the function at build time. Constant; threads: any.

#include <span>

#include "musher/view/http/assets.hpp"

namespace musher::view {

std::span<const http::Asset> PageFiles();

}  // namespace musher::view
