#include "musher/transport/security/check.hpp"

#include <filesystem>

#include "musher/base/date_text.hpp"
#include "musher/base/own_folder.hpp"
#include "musher/transport/security/certificates.hpp"
#include "musher/transport/security/key_files.hpp"

namespace musher::transport::keys {
namespace {

Error InvalidIdentity(const std::string& message) {
  return {kCodePermissionDenied, message};
}

Error NotVouchedFor(const KeyFolder& folder, const std::string& name, X509* certificate,
                    int reason) {
  const std::string file = folder.Certificate(name);
  switch (reason) {
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return InvalidIdentity(file + " has expired on " +
                             FormatUtc(ValidityOf(certificate).not_after) + "; `musher keys add " +
                             name + " --force` makes a new one");
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return InvalidIdentity(file + " is valid from " +
                             FormatUtc(ValidityOf(certificate).not_before) + "; check the clock");
    case X509_V_ERR_CERT_REVOKED:
      return InvalidIdentity(file + " is revoked in " + folder.Revocations());
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_CERT_SIGNATURE_FAILURE:
      return InvalidIdentity(file + " was not issued by the CA of " + folder.IdentityCa());
    default:
      return InvalidIdentity(file + ": " + X509_verify_cert_error_string(reason));
  }
}

// The text between <tag> and </tag>; the requested tags occur once in each document that we sign.
std::string Tagged(const std::string& xml, const std::string& tag) {
  const std::size_t begin = xml.find("<" + tag + ">");
  const std::size_t end = xml.find("</" + tag + ">");
  if (begin == std::string::npos || end == std::string::npos) return {};
  const std::size_t text = begin + tag.size() + 2;
  return xml.substr(text, end - text);
}

Result<> CheckDocuments(const KeyFolder& folder, const std::string& name, X509* certificate) {
  const auto authority = ReadCertificate(folder.PermissionsCa());
  if (!authority) return authority.error();
  for (const std::string& file : {folder.Governance(), folder.Permissions(name)}) {
    const auto text = ReadText(file);
    if (!text) return text.error();
    const auto document = Signed(text.value(), authority.value().get());
    if (!document) {
      return InvalidIdentity(file + " was not signed by the CA of " + folder.PermissionsCa() +
                             ", or was changed");
    }
    if (file == folder.Governance()) continue;
    const std::string subject = Tagged(document.value(), "subject_name");
    if (subject != SubjectOf(certificate)) {
      return InvalidIdentity(file + " is for " + subject + ", not for " + SubjectOf(certificate) +
                             " of " + folder.Certificate(name));
    }
  }
  return Ok();
}

}  // namespace

Result<WallTime> Check(const KeyFolder& folder, const std::string& identity, KeyUse use) {
  if (auto own = CheckOwnFolder(folder.path()); !own) return own.error();
  const auto authority = ReadCertificate(folder.IdentityCa());
  if (!authority) {
    return InvalidIdentity(authority.error().message +
                           "; `musher keys init` creates a robot's credentials");
  }
  const auto revocations = ReadRevocations(folder.Revocations());
  if (!revocations) return revocations.error();
  const auto certificate = ReadCertificate(folder.Certificate(identity));
  if (!certificate) {
    std::error_code error;
    const bool broken = std::filesystem::exists(folder.Certificate(identity), error);
    return InvalidIdentity(certificate.error().message + "; `musher keys add " + identity +
                           (broken ? " --force` replaces it" : "` creates an identity"));
  }
  X509* own = certificate.value().get();
  const auto key = ReadKey(folder.Key(identity), use == KeyUse::kByAnyProcess);
  if (!key) return key.error();
  if (X509_check_private_key(own, key.value().get()) != 1) {
    ERR_clear_error();
    return InvalidIdentity(folder.Key(identity) + " is not the key of " +
                           folder.Certificate(identity));
  }
  const int reason = Verify(own, authority.value().get(), revocations.value().get());
  if (reason != X509_V_OK) return NotVouchedFor(folder, identity, own, reason);
  if (auto good = CheckDocuments(folder, identity, own); !good) return good.error();
  return ValidityOf(own).not_after;
}

}  // namespace musher::transport::keys
