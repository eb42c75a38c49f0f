#pragma once
// Reads and writes the files of a folder of keys. All fail with the file's name.

#include <string>

#include "musher/transport/keys/openssl.hpp"

namespace musher::transport::keys {

// A key that others can read is refused.
Result<std::string> ReadText(const std::string& file);
Result<CertificatePtr> ReadCertificate(const std::string& file);
Result<CrlPtr> ReadRevocations(const std::string& file);
Result<KeyPtr> ReadKey(const std::string& file);

// Files appear whole, or not at all, and never with another mode than the one they are to have.
// Replaces a file only if `replace`.
Result<> MakeFolder(const std::string& folder);  // 0700; one that is there is left as it is
Result<> WriteText(const std::string& file, const std::string& text, bool replace);
Result<> WriteCertificate(const std::string& file, X509* certificate, bool replace);
Result<> WriteRevocations(const std::string& file, X509_CRL* revocations);
Result<> WriteKey(const std::string& file, EVP_PKEY* key, bool replace);  // 0600

}  // namespace musher::transport::keys
