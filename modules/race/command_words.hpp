#pragma once
// What a person types on state_machine/start_command, as the command that it means. Pure.
// Threads: any.

#include <string>
#include <string_view>

#include "musher/base/result.hpp"
#include "musher/modules/race/course.hpp"

namespace musher::race {

// Upper and lower case are the same. A state's name alone is START:<state>, and a value alone sets
// the result that has it: "in_qrb" is "START:IN_QRB", "a-2" is "SET_QR_A:A-2". A text that means
// none of these is returned as it is; a value of two results is an error that names both commands.
Result<std::string> CommandOf(const Course& course, std::string_view typed);

}  // namespace musher::race
