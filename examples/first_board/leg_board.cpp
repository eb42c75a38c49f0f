// The program of the board.

#include "leg_board.hpp"

int main() {
  LegBoard board;
  return board.Run();
}
