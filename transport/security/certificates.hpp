#pragma once
// Creates and verifies keys, certificates and signed documents. Elliptic curve P-256, SHA-256.

#include <string>
#include <string_view>

#include "musher/transport/security/openssl.hpp"
#include "musher/transport/security/wall_time.hpp"

namespace musher::transport::keys {

struct Validity {
  WallTime not_before;
  WallTime not_after;
};

Result<KeyPtr> NewKey();

// A self-signed CA certificate.
Result<CertificatePtr> NewAuthority(const std::string& name, const Validity& validity,
                                    EVP_PKEY* key);
// The certificate of an identity, with its role and a unique serial number.
Result<CertificatePtr> NewCertificate(const std::string& name, const std::string& role,
                                      const Validity& validity, EVP_PKEY* key, X509* authority,
                                      EVP_PKEY* authority_key);

// The revocation list of `authority`, valid as long as `authority`: the entries of `old` (may be
// null) and `revoked` (may be null).
Result<CrlPtr> NewRevocations(X509_CRL* old, X509* revoked, X509* authority,
                              EVP_PKEY* authority_key);
bool IsRevoked(X509_CRL* revocations, X509* certificate);

// The subject in the form that DDS Security compares, RFC 2253.
std::string SubjectOf(const X509* certificate);
std::string NameOf(const X509* certificate);
std::string RoleOf(const X509* certificate);  // empty: it names none
Validity ValidityOf(const X509* certificate);

// X509_V_OK if `authority` currently vouches for `certificate`, else why not. `revocations` may be
// null.
int Verify(X509* certificate, X509* authority, X509_CRL* revocations);

// Signs a document as S/MIME; and returns the document if the signature is `signer`'s.
Result<std::string> Sign(const std::string& document, X509* signer, EVP_PKEY* signer_key);
Result<std::string> Signed(const std::string& smime, X509* signer);

}  // namespace musher::transport::keys
