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
//   disk:…              the number of a disk that stays in it: NVMe, eMMC, SD, or SATA. A disk that
//                       is moved to another computer takes the state folder along, which is then
//                       no copy. Beside another part only: a container has the disks of its host
// What is plugged into USB is no part: it is in another computer tomorrow. Those that vendors leave
// unset ("Default string") are no parts. `root`: of the files, for tests.
std::vector<std::string> ComputerParts(const std::string& root = "");

// Whether `now` and `stored` are the parts of two computers: both lists have parts of one kind, and
// no part is in both. A replaced network card changes one part only. What this user, or the kernel,
// shows of one list and not of the other proves nothing.
bool IsOtherComputer(const std::vector<std::string>& stored, const std::vector<std::string>& now);

// What to store next: the parts `now`, and each stored part whose kind has no part in `now`,
// because this user may not read it.
std::vector<std::string> ComputerToStore(const std::vector<std::string>& stored,
                                         std::vector<std::string> now);

}  // namespace musher
