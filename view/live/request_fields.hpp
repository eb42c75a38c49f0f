#pragma once
// Whether a request of a page or a script has the fields that its path knows. A field that is
// misspelt, or of another type, is no missing one: a switch of one actuator would be one of the
// machine, and the release of one stop that of all.
//
// Pure. Threads: any.

#include <nlohmann/json_fwd.hpp>
#include <string_view>

#include "musher/base/result.hpp"

namespace musher::view {

// `body`: an object. Fails with kCodeParametersInvalid and a sentence that names the field. A stop,
// a pause and a cancellation are obeyed whatever else they say, and so is any path that is not
// known here.
Result<> CheckFields(std::string_view path, const nlohmann::json& body);

}  // namespace musher::view
