#include "musher/controller/storage/computer.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "musher/controller/storage/state_store.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::computer_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

using Parts = std::vector<std::string>;

const Parts kRobot{"mac:eth", "mac:wifi", "serial:a1", "uuid:a"};

TEST(Computer, IsAnotherOneIfBothAreKnownAndHaveNothingInCommon) {
  struct Row {
    const char* what;
    Parts stored;
    Parts now;
    bool other;
  };
  const std::vector<Row> rows{
      {"the same", kRobot, kRobot, false},
      {"the image on a second robot", kRobot, {"mac:eth2", "uuid:b"}, true},
      {"read without root's rights", kRobot, {"mac:eth", "mac:wifi"}, false},
      {"another network card", kRobot, {"mac:new", "mac:wifi"}, false},
      {"another network card, and the board", kRobot, {"mac:new", "uuid:a"}, false},
      {"its only card is all that was known", {"mac:a"}, {"mac:b"}, true},
      {"its only card, and not the disk", {"disk:1", "mac:a"}, {"disk:1", "mac:b"}, false},
      {"an image of it", {"disk:1", "mac:a"}, {"disk:2", "mac:b"}, true},
      {"its card is not shown, and a disk is", {"mac:a"}, {"disk:1"}, false},
      {"an ARM board", {"device-tree:1"}, {"device-tree:2"}, true},
      {"an earlier version had stored nothing", {}, kRobot, false},
      {"a container", kRobot, {}, false},
      {"a container on another computer", {}, {}, false},
  };
  for (const Row& row : rows) {
    EXPECT_EQ(IsOtherComputer(row.stored, row.now), row.other) << row.what;
  }
}

TEST(Computer, KeepsWhatThisUserCannotRead) {
  EXPECT_EQ(ComputerToStore(kRobot, {"mac:eth"}), (Parts{"mac:eth", "serial:a1", "uuid:a"}));
  EXPECT_EQ(ComputerToStore(kRobot, {}), (Parts{"mac:eth", "mac:wifi", "serial:a1", "uuid:a"}));
  EXPECT_EQ(ComputerToStore({}, kRobot), kRobot);
}

class ComputerFiles : public ::testing::Test {
 protected:
  void Write(const std::string& file, const std::string& text) const {
    const fs::path path = folder_ / file;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  void AddCard(const std::string& name, const std::string& address, const std::string& type,
               bool is_device = true) const {
    Write("sys/class/net/" + name + "/address", address + "\n");
    Write("sys/class/net/" + name + "/addr_assign_type", type + "\n");
    if (is_device) Write("sys/class/net/" + name + "/device/vendor", "x");
  }
  Parts Found() const { return ComputerParts(folder_.path()); }

  const TempFolder folder_;
};

TEST_F(ComputerFiles, ShowItsNumbersAndItsPermanentAddresses) {
  EXPECT_THAT(Found(), IsEmpty());
  AddCard("wlan0", "02:11:22:33:44:55", "0");
  AddCard("eth0", "00:11:22:33:44:56", "0");
  AddCard("wlan1", "6a:11:22:33:44:57", "3");           // set by a program
  AddCard("docker0", "02:42:22:33:44:58", "0", false);  // no device
  AddCard("lo", "00:00:00:00:00:00", "0");
  EXPECT_THAT(Found(), ElementsAre("mac:001122334456", "mac:021122334455"));
  Write("sys/class/dmi/id/product_uuid", "4C4C4544-0042-4810-8056-B2C04F4B3333\n");
  Write("sys/class/dmi/id/product_serial", "Default string\n");
  Write("proc/device-tree/serial-number", std::string("1423522012345\0", 14));
  EXPECT_THAT(Found(), ElementsAre("device-tree:1423522012345", "mac:001122334456",
                                   "mac:021122334455", "uuid:4c4c4544004248108056b2c04f4b3333"));
}

// A boot with an adapter plugged in was another computer, whose actuators on other hosts obeyed no
// more; and an adapter that was moved made a copied image the same one.
TEST_F(ComputerFiles, ShowNothingThatIsPluggedIntoUsb) {
  Write("sys/devices/pci0000:00/usb1/1-2/vendor", "x");
  AddCard("usb0", "00:11:22:33:44:60", "0", false);
  fs::create_directory_symlink(folder_ / "sys/devices/pci0000:00/usb1/1-2",
                               folder_ / "sys/class/net/usb0/device");
  Write("sys/devices/pci0000:00/usb1/1-3/block/sda/device/wwid", "naa.5002538e40a1b2c3\n");
  fs::create_directories(folder_ / "sys/block");
  fs::create_directory_symlink(folder_ / "sys/devices/pci0000:00/usb1/1-3/block/sda",
                               folder_ / "sys/block/sda");
  EXPECT_THAT(Found(), IsEmpty());
  AddCard("eth0", "00:11:22:33:44:56", "0");
  EXPECT_THAT(Found(), ElementsAre("mac:001122334456"));
}

TEST_F(ComputerFiles, ShowTheDisksThatStayInIt) {
  Write("sys/block/nvme0n1/device/serial", "S4EVNX0R123456     \n");
  Write("sys/block/mmcblk0/device/serial", "0x1b2c3d4e\n");
  Write("sys/block/mmcblk0/device/cid", "150100424a544434520a1b2c3d4e5f60\n");
  Write("sys/block/mmcblk0boot0/device/cid", "150100424a544434520a1b2c3d4e5f60\n");
  Write("sys/block/sda/device/wwid", "naa.5002538e40a1b2c3\n");
  Write("sys/block/sdb/device/wwid", "t10.ATA     QEMU HARDDISK                QM00001 \n");
  Write("sys/block/sdc/device/wwid", "naa.5002538e40a1b2c4\n");
  Write("sys/block/sdc/removable", "1\n");
  Write("sys/block/loop0/size", "0\n");
  EXPECT_THAT(Found(), IsEmpty()) << "as in a container";
  AddCard("eth0", "00:11:22:33:44:56", "0");
  EXPECT_THAT(Found(),
              ElementsAre("disk:150100424a544434520a1b2c3d4e5f60", "disk:naa5002538e40a1b2c3",
                          "disk:s4evnx0r123456", "mac:001122334456"));
}

// A copy of a virtual machine has them, too.
TEST_F(ComputerFiles, ShowNoNumberOfASimulatedDisk) {
  AddCard("eth0", "00:11:22:33:44:56", "0");
  Write("sys/block/nvme0n1/device/model", "QEMU NVMe Ctrl\n");
  Write("sys/block/nvme0n1/device/serial", "deadbeef01\n");
  Write("sys/block/nvme1n1/device/model", "VMware Virtual NVMe Disk\n");
  Write("sys/block/nvme1n1/device/serial", "VMWare NVME_0000\n");
  Write("sys/block/mmcblk0/device/serial", "0x00000000\n");
  EXPECT_THAT(Found(), ElementsAre("mac:001122334456"));
}

TEST_F(ComputerFiles, WithNumbersThatAVendorHasLeftUnsetShowNone) {
  for (const char* unset :
       {"03000200-0400-0500-0006-000700080009", "00000000-0000-0000-0000-000000000000",
        "ffffffff-ffff-ffff-ffff-ffffffffffff", "To be filled by O.E.M.", "0123456789", "", "N/A",
        "System Serial Number"}) {
    Write("sys/class/dmi/id/product_uuid", unset);
    Write("sys/class/dmi/id/product_serial", unset);
    EXPECT_THAT(Found(), IsEmpty()) << unset;
  }
}

class CopiedFolder : public ::testing::Test {
 protected:
  // As after a boot: without `same_boot` the lock's file is of an earlier one.
  StateStore OpenOn(const Parts& computer, bool same_boot = false) {
    if (!same_boot) std::ofstream(folder_ / "state/controller.lock") << "7 robot\nanother boot\n";
    MachineOrigin machine{"robot", "", 0, folder_ / "robot.toml"};
    machine.computer = computer;
    auto store = StateStore::Open(folder_ / "state", machine);
    EXPECT_TRUE(store) << store.error().message;
    return std::move(store).value();
  }
  std::string Id() const { return LoadOrigin(folder_ / "state").value().id; }

  const TempFolder folder_;
};

// Two robots with one image: a stop, a command and a release of one of them were the other one's,
// too.
TEST_F(CopiedFolder, GetsAnIdOfItsOwnOnAnotherComputer) {
  {
    StateStore first = OpenOn(kRobot);
    first.SetMachineId("5982c7ee-4f4e");
    ASSERT_TRUE(first.SaveMachineId());
  }
  EXPECT_FALSE(OpenOn({"mac:new", "mac:wifi"}).copied_from());
  EXPECT_FALSE(OpenOn({}).copied_from()) << "nothing is known";
  EXPECT_EQ(Id(), "5982c7ee-4f4e");
  const StateStore copy = OpenOn({"mac:second", "uuid:b"});
  EXPECT_EQ(copy.copied_from(), "5982c7ee-4f4e");
  EXPECT_NE(copy.machine_id(), "5982c7ee-4f4e");
  EXPECT_EQ(copy.machine_id().size(), 36U);
  EXPECT_EQ(Id(), copy.machine_id());
}

// Its actuators run on, with that id.
TEST_F(CopiedFolder, IsNoneInOneBootWhateverIsPluggedIn) {
  {
    StateStore first = OpenOn({"mac:first"});
    first.SetMachineId("5982c7ee-4f4e");
    ASSERT_TRUE(first.SaveMachineId());
  }
  EXPECT_EQ(OpenOn({"mac:second"}, true).machine_id(), "5982c7ee-4f4e");
  EXPECT_TRUE(OpenOn({"mac:third"}).copied_from());
}

// Without root, and on no ARM board, its network card was all that it was known by.
TEST_F(CopiedFolder, IsNoneWhereItsOnlyNetworkCardWasReplaced) {
  {
    StateStore first = OpenOn({"disk:1", "mac:first"});
    first.SetMachineId("5982c7ee-4f4e");
    ASSERT_TRUE(first.SaveMachineId());
  }
  EXPECT_EQ(OpenOn({"disk:1", "mac:second"}).machine_id(), "5982c7ee-4f4e");
  EXPECT_TRUE(OpenOn({"disk:2", "mac:third"}).copied_from());
}

// A panel that stops a fleet publishes its stop for as long as it is pressed. Released by a person
// at one robot, it was over at the one with a copy of its disk, too.
TEST_F(CopiedFolder, HasNoReleaseOfTheOtherComputerAndKeepsItsStops) {
  const StopId released(5);
  const StopId replaced(6);
  const StopId engaged(7);
  {
    StateStore first = OpenOn(kRobot);
    first.SetMachineId("5982c7ee-4f4e");
    ASSERT_TRUE(first.SaveMachineId());
    StoredStops stops;
    stops.engaged = {{engaged, "panel", "smoke"}};
    stops.released = {released, replaced};
    stops.replaced = {replaced};
    stops.awaits_request = true;
    ASSERT_TRUE(first.SaveEmergencyStops(stops));
  }
  EXPECT_EQ(OpenOn(kRobot).LoadEmergencyStops().released, (std::vector{released, replaced}))
      << "on the same computer they hold";
  const Parts second{"mac:second", "uuid:b"};
  for (int start = 0; start < 2; ++start) {
    const StateStore copy = OpenOn(second);
    ASSERT_EQ(copy.copied_from().has_value(), start == 0);
    const StoredStops stops = copy.LoadEmergencyStops();
    EXPECT_THAT(stops.released, IsEmpty());
    EXPECT_THAT(stops.replaced, IsEmpty());
    ASSERT_EQ(stops.engaged.size(), 1U);
    EXPECT_EQ(stops.engaged.front().id, engaged);
    EXPECT_TRUE(stops.awaits_request);
  }
}

TEST_F(CopiedFolder, KeepsTheIdOfItsOwnAtTheNextStart) {
  {
    StateStore first = OpenOn(kRobot);
    first.SetMachineId("5982c7ee-4f4e");
    ASSERT_TRUE(first.SaveMachineId());
  }
  const Parts second{"mac:second", "uuid:b"};
  const std::string id = OpenOn(second).machine_id();
  const StateStore again = OpenOn({"mac:second"});
  EXPECT_EQ(again.machine_id(), id);
  EXPECT_FALSE(again.copied_from());
  EXPECT_NE(id, "5982c7ee-4f4e");
}

}  // namespace musher::computer_test
