#pragma once
// A QR code of a short text, such as a link, and its drawing in a terminal (ISO/IEC 18004: byte
// mode, versions 1 to 5, error correction L). Pure; threads: any.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace musher::view {

inline constexpr std::size_t kMostQrBytes = 106;

// A square of modules; true is dark.
using QrModules = std::vector<std::vector<bool>>;

// nullopt: the text is longer than kMostQrBytes.
std::optional<QrModules> QrCode(std::string_view text);

// Lines of half blocks, two rows of modules a line, with their own colours: black on white on every
// terminal, with a margin.
std::string QrText(const QrModules& modules);

}  // namespace musher::view
