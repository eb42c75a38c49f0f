// Installs a bundle on real files, and kills itself before the operation of that number, or in the
// middle of it where it is a write.
//
//   ota_killed_installer ROOT BUNDLE NUMBER     exit code 0: it came to its end before

#include <signal.h>

#include <cstdio>
#include <cstdlib>

#include "musher/ota/install.hpp"
#include "musher/ota/posix_disk.hpp"

namespace musher::ota {
namespace {

class FatalDisk : public PosixDisk {
 public:
  explicit FatalDisk(int number) : left_(number) {}

  Result<std::unique_ptr<Writer>> Create(const std::string& path, unsigned mode) override {
    Step();
    auto writer = PosixDisk::Create(path, mode);
    if (!writer) return writer;
    return std::unique_ptr<Writer>(std::make_unique<FatalWriter>(*this, std::move(writer).value()));
  }
  Result<> Sync(const std::string& path) override {
    Step();
    return PosixDisk::Sync(path);
  }
  Result<> MakeFolder(const std::string& path) override {
    Step();
    return PosixDisk::MakeFolder(path);
  }
  Result<> MakeLink(const std::string& target, const std::string& path) override {
    Step();
    return PosixDisk::MakeLink(target, path);
  }
  Result<> Rename(const std::string& from, const std::string& to) override {
    Step();
    return PosixDisk::Rename(from, to);
  }
  Result<> Remove(const std::string& path) override {
    Step();
    return PosixDisk::Remove(path);
  }

 private:
  class FatalWriter : public Writer {
   public:
    FatalWriter(FatalDisk& disk, std::unique_ptr<Writer> writer)
        : disk_(disk), writer_(std::move(writer)) {}
    Result<> Write(std::string_view bytes) override {
      disk_.Step();
      if (auto half = writer_->Write(bytes.substr(0, bytes.size() / 2)); !half) return half;
      disk_.Step();
      return writer_->Write(bytes.substr(bytes.size() / 2));
    }

   private:
    FatalDisk& disk_;
    std::unique_ptr<Writer> writer_;
  };

  void Step() {
    if (--left_ == 0) raise(SIGKILL);
  }

  int left_;
};

Result<> Install(Disk& disk, const std::string& path, const std::string& bundle) {
  const auto root = Root::Open(disk, path);
  if (!root) return root.error();
  auto installation = Installation::Begin(root.value(), bundle, {}, std::nullopt);
  if (!installation) return installation.error();
  Installation& steps = installation.value();
  if (auto r = steps.Check({}); !r) return r;
  if (auto r = steps.Prepare(); !r) return r;
  if (auto r = steps.Copy({}); !r) return r;
  if (auto r = steps.CheckWritten({}); !r) return r;
  if (auto r = steps.MarkTrialBoot(); !r) return r;
  const auto boot = root.value().Boot();
  if (!boot) return boot.error();
  return root.value().EndTrialBoot(boot.value().version.text, Ok());
}

}  // namespace
}  // namespace musher::ota

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  musher::ota::FatalDisk disk(std::atoi(argv[3]));
  const auto installed = musher::ota::Install(disk, argv[1], argv[2]);
  if (!installed) std::fprintf(stderr, "%s\n", installed.error().message.c_str());
  return installed ? 0 : 1;
}
