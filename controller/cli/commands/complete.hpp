#pragma once
// The completions of a word on the command line.

#include <string>
#include <vector>

#include "musher/controller/cli/console/console.hpp"
#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

// `musher complete WORD...`: the completions of the last word. The installed scripts call it.
struct CompleteOptions {
  struct Word {
    std::string text;
    std::string meaning;
  };
  std::vector<Word> words;  // from the grammar
  Names names = Names::kNone;
  std::string begin;   // prefix that each completion must have
  std::string prefix;  // text already typed before it: "--format="
  std::string config;  // complete names of this config; empty: of the running machine
  std::string application;
  std::string skill;  // on the command line
};

// Prints them, one per line with its meaning.
ExitCode Complete(const CompleteOptions& options, const GlobalOptions& global, Console& console);

}  // namespace musher::cli
