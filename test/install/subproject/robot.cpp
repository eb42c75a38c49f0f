#include <cstdio>
#include <string>

#include "musher/base/version.hpp"

int main() {
  std::puts(("Musher " + std::string(musher::Version())).c_str());
}
