#pragma once
// Reads and writes the files of a key folder. All errors name the file.

#include <string>

#include "musher/transport/security/openssl.hpp"

namespace musher::transport::keys {

Result<std::string> ReadText(const std::string& file);
Result<CertificatePtr> ReadCertificate(const std::string& file);
Result<CrlPtr> ReadRevocations(const std::string& file);
// Refuses a key that other users can read. `of_any_user`: root reads one of whom it belongs to.
Result<KeyPtr> ReadKey(const std::string& file, bool of_any_user = false);

// Writes are atomic, and files have their final mode from the start. Replaces a file only if
// `replace`.
Result<> MakeFolder(const std::string& folder);  // 0700; an existing one has to be ours
Result<> WriteText(const std::string& file, const std::string& text, bool replace);
Result<> WriteCertificate(const std::string& file, X509* certificate, bool replace);
Result<> WriteRevocations(const std::string& file, X509_CRL* revocations);
Result<> WriteKey(const std::string& file, EVP_PKEY* key, bool replace);  // 0600

}  // namespace musher::transport::keys
