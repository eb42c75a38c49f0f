#include "musher/transport/security/key_files.hpp"

#include <fcntl.h>
#include <openssl/pem.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <functional>

#include "musher/base/host.hpp"
#include "musher/base/own_folder.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/base/words.hpp"

namespace musher::transport::keys {
namespace {

constexpr mode_t kForAll = 0644;
constexpr mode_t kForOwner = 0600;
constexpr mode_t kOthers = 077;
constexpr std::size_t kLargestFile = 1 << 20;  // bytes

Result<UniqueFd> Open(const std::string& file) {
  UniqueFd fd(open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (fd.get() < 0) return SystemError(file);
  struct stat info {};
  if (fstat(fd.get(), &info) != 0) return SystemError(file);
  if (!S_ISREG(info.st_mode)) return Error{kCodeFailed, file + " is not a file"};
  if (info.st_size == 0) return Error{kCodeFailed, file + " is empty"};
  return fd;
}

BioPtr Bio(const UniqueFd& fd) {
  return BioPtr(BIO_new_fd(fd.get(), BIO_NOCLOSE));
}

// `write` fills a new file beside `file`, which is renamed to `file` once it is complete and
// synced.
Result<> Write(const std::string& file, mode_t mode, bool replace,
               const std::function<bool(BIO*)>& write) {
  const std::string draft = file + ".new";
  unlink(draft.c_str());  // left by an interrupted write
  const UniqueFd fd(open(draft.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode));
  if (fd.get() < 0) return SystemError(file);
  const BioPtr bio = Bio(fd);
  if (!bio || !write(bio.get()) || fsync(fd.get()) != 0) {
    unlink(draft.c_str());
    return CryptoError(file + " cannot be written");
  }
  // link() does not replace a file, rename() does.
  const int placed =
      replace ? rename(draft.c_str(), file.c_str()) : link(draft.c_str(), file.c_str());
  const int error = errno;
  unlink(draft.c_str());
  if (placed != 0) return SystemError(file, error);
  return Ok();
}

}  // namespace

Result<std::string> ReadText(const std::string& file) {
  const auto fd = Open(file);
  if (!fd) return fd.error();
  std::string text(kLargestFile, '\0');
  const ssize_t size = read(fd.value().get(), text.data(), text.size());
  if (size < 0) return SystemError(file);
  text.resize(static_cast<std::size_t>(size));
  return text;
}

Result<CertificatePtr> ReadCertificate(const std::string& file) {
  const auto fd = Open(file);
  if (!fd) return fd.error();
  CertificatePtr certificate(PEM_read_bio_X509(Bio(fd.value()).get(), nullptr, nullptr, nullptr));
  if (!certificate) return CryptoError(file + " is not a certificate (PEM)");
  return certificate;
}

Result<CrlPtr> ReadRevocations(const std::string& file) {
  const auto fd = Open(file);
  if (!fd) return fd.error();
  CrlPtr list(PEM_read_bio_X509_CRL(Bio(fd.value()).get(), nullptr, nullptr, nullptr));
  if (!list) return CryptoError(file + " is not a list of revoked certificates (PEM)");
  return list;
}

Result<KeyPtr> ReadKey(const std::string& file, bool of_any_user) {
  const auto fd = Open(file);
  if (!fd) return fd.error();
  struct stat info {};
  if (fstat(fd.value().get(), &info) != 0) return SystemError(file);
  const bool accepted = of_any_user && geteuid() == 0;
  if (info.st_uid != geteuid() && info.st_uid != 0 && !accepted) {
    return Error{kCodePermissionDenied, file + " belongs to user " + std::to_string(info.st_uid) +
                                            ", who can read it; run `chown " +
                                            std::to_string(geteuid()) + " " + ShellWord(file) +
                                            "`"};
  }
  if ((info.st_mode & kOthers) != 0) {
    return Error{kCodePermissionDenied,
                 file + " is readable by others; run `chmod 600 " + ShellWord(file) + "`"};
  }
  // Without a callback libcrypto would prompt on the terminal for the password of an encrypted key.
  const auto no_password = [](char*, int, int, void*) { return -1; };
  KeyPtr key(PEM_read_bio_PrivateKey(Bio(fd.value()).get(), nullptr, no_password, nullptr));
  if (!key) return CryptoError(file + " is not a private key (PEM, without a password)");
  return key;
}

Result<> MakeFolder(const std::string& folder) {
  std::error_code error;
  const auto parent = std::filesystem::path(folder).parent_path();
  if (!parent.empty()) std::filesystem::create_directories(parent, error);
  if (mkdir(folder.c_str(), 0700) == 0) return Ok();
  if (errno == EEXIST && std::filesystem::is_directory(folder, error)) {
    return CheckOwnFolder(folder);
  }
  return SystemError(folder);
}

Result<> WriteText(const std::string& file, const std::string& text, bool replace) {
  return Write(file, kForAll, replace, [&](BIO* bio) {
    return BIO_write(bio, text.data(), static_cast<int>(text.size())) ==
           static_cast<int>(text.size());
  });
}

Result<> WriteCertificate(const std::string& file, X509* certificate, bool replace) {
  return Write(file, kForAll, replace,
               [&](BIO* bio) { return PEM_write_bio_X509(bio, certificate) == 1; });
}

Result<> WriteRevocations(const std::string& file, X509_CRL* revocations) {
  return Write(file, kForAll, true,
               [&](BIO* bio) { return PEM_write_bio_X509_CRL(bio, revocations) == 1; });
}

Result<> WriteKey(const std::string& file, EVP_PKEY* key, bool replace) {
  return Write(file, kForOwner, replace, [&](BIO* bio) {
    return PEM_write_bio_PKCS8PrivateKey(bio, key, nullptr, nullptr, 0, nullptr, nullptr) == 1;
  });
}

}  // namespace musher::transport::keys
