// The program of the garden. With --models it prints its nodes, for editors and `musher tree
// check`.

#include <iostream>
#include <string_view>

#include "gardener.hpp"
#include "musher/behavior/tree/models.hpp"

int main(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--models") {
    Garden garden;
    tree::Factory factory;
    if (!AddNodes(factory, garden)) return 1;
    std::cout << tree::ModelsXml(factory);
    return 0;
  }
  Gardener gardener;
  return gardener.Run();
}
