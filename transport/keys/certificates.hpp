#pragma once
// Makes and judges the objects that keys, certificates and signed documents consist of. Elliptic
// curve P-256, SHA-256.

#include <string>
#include <string_view>

#include "musher/transport/keys/openssl.hpp"
#include "musher/transport/keys/rights.hpp"

namespace musher::transport::keys {

struct Validity {
  WallTime not_before;
  WallTime not_after;
};

Result<KeyPtr> NewKey();

// A certificate that signs others, and itself.
Result<CertificatePtr> NewAuthority(const std::string& name, const Validity& validity,
                                    EVP_PKEY* key);
// Of an identity; its role is in it, and a number that no other certificate has.
Result<CertificatePtr> NewCertificate(const std::string& name, Role role, const Validity& validity,
                                      EVP_PKEY* key, X509* authority, EVP_PKEY* authority_key);

// The list of what `authority` has revoked, valid as long as `authority`: `old` (may be null) and
// `revoked` (may be null).
Result<CrlPtr> NewRevocations(X509_CRL* old, X509* revoked, X509* authority,
                              EVP_PKEY* authority_key);
bool IsRevoked(X509_CRL* revocations, X509* certificate);

// The subject as DDS Security compares it, RFC 2253.
std::string SubjectOf(const X509* certificate);
std::string NameOf(const X509* certificate);
std::optional<Role> RoleOf(const X509* certificate);
Validity ValidityOf(const X509* certificate);

// Why `authority` does not vouch for `certificate` now; X509_V_OK where it does. `revocations` may
// be null.
int Verify(X509* certificate, X509* authority, X509_CRL* revocations);

// The document with its signature, as S/MIME; and back, where the signature is `signer`'s.
Result<std::string> Sign(const std::string& document, X509* signer, EVP_PKEY* signer_key);
Result<std::string> Signed(const std::string& smime, X509* signer);

}  // namespace musher::transport::keys
