#pragma once
// What a computer is known by, so that a state folder in an image that is written to several
// computers does not give them one machine id.
//
// Threads: any; ComputerParts() reads small files of the kernel.

#include <string>
#include <string_view>
#include <vector>

namespace musher {

// Each part is one word, its kind first, sorted; empty where nothing is known, as in most
// containers:
//   uuid:…, serial:…    of the mainboard's firmware (DMI); as a rule only root may read them
//   device-tree:…       the serial number of an ARM board
//   mac:…               the permanent address of a network card
// Those that vendors leave unset ("Default string") are no parts. `root`: of the files, for tests.
std::vector<std::string> ComputerParts(const std::string& root = "");

// Whether the computer with the parts `now` is another one than that with the parts `stored`: both
// are known, and have nothing in common. A network card that was replaced changes one part.
bool IsOtherComputer(const std::vector<std::string>& stored, const std::vector<std::string>& now);

// What to store next: the parts `now`, and those stored ones of whose kind none is known now: this
// user may not read them.
std::vector<std::string> ComputerToStore(const std::vector<std::string>& stored,
                                         std::vector<std::string> now);

}  // namespace musher
