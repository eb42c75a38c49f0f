#include "musher/wire/security/authority.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

#include "musher/base/own_folder.hpp"
#include "musher/transport/security/certificates.hpp"
#include "musher/transport/security/key_files.hpp"

namespace musher::transport::keys {
namespace {

constexpr std::chrono::days kAuthorityLife(3650);
// A robot's clock may be behind that of the computer that creates its credentials.
constexpr std::chrono::days kClockSlack(1);

WallTime Now() {
  return std::chrono::time_point_cast<std::chrono::seconds>(std::chrono::system_clock::now());
}

bool Exists(const std::string& file) {
  return access(file.c_str(), F_OK) == 0;
}

// A certificate authority with its key.
struct CertificateAuthority {
  CertificatePtr certificate;
  KeyPtr key;
};

Result<CertificateAuthority> ReadAuthority(const std::string& certificate_file,
                                           const std::string& key_file) {
  for (const std::string& file : {certificate_file, key_file}) {
    if (auto own = CheckOwnFolder(std::filesystem::path(file).parent_path()); !own) {
      return own.error();
    }
  }
  auto certificate = ReadCertificate(certificate_file);
  if (!certificate) return certificate.error();
  if (!Exists(key_file)) {
    return Error{kCodeFailed, key_file +
                                  " is missing: issue and revoke identities where the folder "
                                  "ca/ is kept"};
  }
  auto key = ReadKey(key_file);
  if (!key) return key.error();
  return CertificateAuthority{std::move(certificate).value(), std::move(key).value()};
}

Result<CertificateAuthority> MakeAuthority(const std::string& name,
                                           const std::string& certificate_file,
                                           const std::string& key_file, bool force) {
  auto key = NewKey();
  if (!key) return key.error();
  const WallTime now = Now();
  auto certificate =
      NewAuthority(name, {now - kClockSlack, now + kAuthorityLife}, key.value().get());
  if (!certificate) return certificate.error();
  if (auto r = WriteKey(key_file, key.value().get(), force); !r) return r.error();
  if (auto r = WriteCertificate(certificate_file, certificate.value().get(), force); !r) {
    return r.error();
  }
  return CertificateAuthority{std::move(certificate).value(), std::move(key).value()};
}

Result<> AddRevoked(const KeyFolder& folder, X509* revoked, const CertificateAuthority& authority) {
  CrlPtr old;
  if (Exists(folder.Revocations())) {
    auto read = ReadRevocations(folder.Revocations());
    if (!read) return read.error();
    old = std::move(read).value();
  }
  auto list = NewRevocations(old.get(), revoked, authority.certificate.get(), authority.key.get());
  if (!list) return list.error();
  return WriteRevocations(folder.Revocations(), list.value().get());
}

Result<> SignInto(const std::string& file, const std::string& document,
                  const CertificateAuthority& signer, bool replace) {
  const auto text = Sign(document, signer.certificate.get(), signer.key.get());
  if (!text) return text.error();
  return WriteText(file, text.value(), replace);
}

Result<> CheckNew(const KeyFolder& folder, const std::string& name) {
  for (const auto& file : {folder.Key(name), folder.Certificate(name), folder.Permissions(name)}) {
    if (Exists(file)) {
      return Error{kCodeFailed, file +
                                    " already exists; --force replaces it and revokes the "
                                    "certificate"};
    }
  }
  return Ok();
}

}  // namespace

Result<> CreateAuthority(const KeyFolder& folder, Protection protection, bool force) {
  if (!force && (Exists(folder.IdentityCa()) || Exists(folder.IdentityCaKey()))) {
    return Error{kCodeFailed, folder.path() +
                                  " already has keys; --force creates new ones and makes those "
                                  "already issued invalid"};
  }
  for (const std::string& one : {folder.path(), folder.CaFolder()}) {
    if (auto made = MakeFolder(one); !made) return made;
  }
  const auto identity =
      MakeAuthority("Musher identity CA", folder.IdentityCa(), folder.IdentityCaKey(), force);
  if (!identity) return identity.error();
  const auto permissions = MakeAuthority("Musher permissions CA", folder.PermissionsCa(),
                                         folder.PermissionsCaKey(), force);
  if (!permissions) return permissions.error();
  unlink(folder.Revocations().c_str());  // of the previous CA
  if (auto made = AddRevoked(folder, nullptr, identity.value()); !made) return made;
  return SignInto(folder.Governance(), GovernanceXml(protection), permissions.value(), force);
}

Result<> Issue(const KeyFolder& folder, const std::string& name, Role role,
               const ExtensionInterfaces& extension, const IssueOptions& options) {
  if (!IsIdentityName(name)) {
    return Error{kCodeParametersInvalid,
                 "'" + name +
                     "' is not a valid identity name: expected letters, digits and '_', no digit "
                     "first, at most 64"};
  }
  if (!options.force) {
    if (auto is_new = CheckNew(folder, name); !is_new) return is_new;
  }
  const auto identity = ReadAuthority(folder.IdentityCa(), folder.IdentityCaKey());
  if (!identity) return identity.error();
  const auto permissions = ReadAuthority(folder.PermissionsCa(), folder.PermissionsCaKey());
  if (!permissions) return permissions.error();
  if (Exists(folder.Certificate(name))) {
    if (auto revoked = Revoke(folder, name); !revoked) return revoked;
  }
  const WallTime end = std::min(Now() + std::chrono::days(options.days),
                                ValidityOf(identity.value().certificate.get()).not_after);
  const Validity validity{std::min(Now() - kClockSlack, end - std::chrono::seconds(1)), end};
  const auto key = NewKey();
  if (!key) return key.error();
  const auto certificate =
      NewCertificate(name, std::string(RoleName(role)), validity, key.value().get(),
                     identity.value().certificate.get(), identity.value().key.get());
  if (!certificate) return certificate.error();
  const Grant grant{name, SubjectOf(certificate.value().get()), role, validity.not_before,
                    validity.not_after};
  const bool force = options.force;
  if (auto r = WriteKey(folder.Key(name), key.value().get(), force); !r) return r;
  if (auto r = WriteCertificate(folder.Certificate(name), certificate.value().get(), force); !r) {
    return r;
  }
  return SignInto(folder.Permissions(name), PermissionsXml(grant, extension), permissions.value(),
                  force);
}

Result<> Revoke(const KeyFolder& folder, const std::string& name) {
  const auto certificate = ReadCertificate(folder.Certificate(name));
  if (!certificate) return certificate.error();
  const auto identity = ReadAuthority(folder.IdentityCa(), folder.IdentityCaKey());
  if (!identity) return identity.error();
  return AddRevoked(folder, certificate.value().get(), identity.value());
}

Result<std::vector<Identity>> List(const KeyFolder& folder) {
  const auto revocations = ReadRevocations(folder.Revocations());
  if (!revocations) return revocations.error();
  std::vector<Identity> identities;
  for (const std::string& name : folder.Identities()) {
    const auto certificate = ReadCertificate(folder.Certificate(name));
    if (!certificate) return certificate.error();
    X509* one = certificate.value().get();
    identities.push_back({name, RoleFrom(RoleOf(one)), ValidityOf(one).not_after,
                          IsRevoked(revocations.value().get(), one), Exists(folder.Key(name))});
  }
  return identities;
}

}  // namespace musher::transport::keys
