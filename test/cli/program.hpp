#pragma once
// The whole program without its process: a command line in, output and exit code out.

#include <sstream>
#include <string>
#include <vector>

#include "musher/cli/run.hpp"
#include "musher/test/support/json_schema.hpp"

namespace musher::cli {

struct Ran {
  int exit = -1;
  std::string out;
  std::string err;
};

inline Ran RunProgram(const std::vector<std::string>& arguments) {
  std::vector<const char*> argv = {"musher"};
  for (const std::string& argument : arguments) argv.push_back(argument.c_str());
  std::ostringstream out;
  std::ostringstream err;
  Ran ran;
  ran.exit = Run(static_cast<int>(argv.size()), argv.data(), out, err, false);
  ran.out = out.str();
  ran.err = err.str();
  testing::CheckDocuments(arguments, ran.out);
  return ran;
}

}  // namespace musher::cli
