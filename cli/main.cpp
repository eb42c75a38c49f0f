#include <unistd.h>

#include <iostream>

#include "musher/cli/run.hpp"

int main(int argc, char** argv) {
  return musher::cli::Run(argc, argv, std::cout, std::cerr, isatty(STDOUT_FILENO) == 1);
}
