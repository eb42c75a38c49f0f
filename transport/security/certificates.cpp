#include "musher/transport/security/certificates.hpp"

#include <openssl/asn1.h>
#include <openssl/ec.h>
#include <openssl/pem.h>
#include <openssl/rand.h>

#include <array>
#include <cstdio>
#include <ctime>

namespace musher::transport::keys {
namespace {

constexpr long kVersion3 = 2;  // X.509 counts from 0
constexpr long kCrlVersion2 = 1;

TimePtr Asn1(WallTime time) {
  return TimePtr(ASN1_TIME_set(nullptr, std::chrono::system_clock::to_time_t(time)));
}

WallTime FromAsn1(const ASN1_TIME* time) {
  std::tm parts{};
  if (ASN1_TIME_to_tm(time, &parts) != 1) return {};
  return std::chrono::time_point_cast<std::chrono::seconds>(
      std::chrono::system_clock::from_time_t(timegm(&parts)));
}

bool AddText(X509_NAME* name, int nid, const std::string& text) {
  return X509_NAME_add_entry_by_NID(name, nid, MBSTRING_UTF8,
                                    reinterpret_cast<const unsigned char*>(text.data()),
                                    static_cast<int>(text.size()), -1, 0) == 1;
}

std::string Text(const X509* certificate, int nid) {
  const X509_NAME* name = X509_get_subject_name(certificate);
  std::array<char, 256> text{};
  const int length = X509_NAME_get_text_by_NID(name, nid, text.data(), text.size());
  return length > 0 ? std::string(text.data(), static_cast<std::size_t>(length)) : std::string();
}

bool Extend(X509* certificate, X509* issuer, int nid, const char* value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  const ExtensionPtr extension(X509V3_EXT_conf_nid(nullptr, &context, nid, value));
  return extension && X509_add_ext(certificate, extension.get(), -1) == 1;
}

// A serial number of 64 random bits, so that no two certificates share one.
std::optional<std::uint64_t> NewNumber() {
  std::uint64_t number = 0;
  if (RAND_bytes(reinterpret_cast<unsigned char*>(&number), sizeof number) != 1) return {};
  return (number >> 1U) | 1U;  // positive, not 0
}

CertificatePtr Draft(std::uint64_t number, const Validity& validity, EVP_PKEY* key) {
  CertificatePtr draft(X509_new());
  const bool done = draft && X509_set_version(draft.get(), kVersion3) == 1 &&
                    ASN1_INTEGER_set_uint64(X509_get_serialNumber(draft.get()), number) == 1 &&
                    X509_set1_notBefore(draft.get(), Asn1(validity.not_before).get()) == 1 &&
                    X509_set1_notAfter(draft.get(), Asn1(validity.not_after).get()) == 1 &&
                    X509_set_pubkey(draft.get(), key) == 1;
  return done ? std::move(draft) : nullptr;
}

std::string Hex(std::uint64_t number) {
  std::array<char, 17> hex{};
  std::snprintf(hex.data(), hex.size(), "%016llx", static_cast<unsigned long long>(number));
  return hex.data();
}

std::string Contents(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return size > 0 ? std::string(data, static_cast<std::size_t>(size)) : std::string();
}

BioPtr Reading(const std::string& text) {
  return BioPtr(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

}  // namespace

Result<KeyPtr> NewKey() {
  KeyPtr key(EVP_EC_gen("P-256"));
  if (!key) return CryptoError("cannot make a key");
  return key;
}

Result<CertificatePtr> NewAuthority(const std::string& name, const Validity& validity,
                                    EVP_PKEY* key) {
  const auto number = NewNumber();
  CertificatePtr made = number ? Draft(*number, validity, key) : nullptr;
  const bool done =
      made && AddText(X509_get_subject_name(made.get()), NID_commonName, name) &&
      X509_set_issuer_name(made.get(), X509_get_subject_name(made.get())) == 1 &&
      Extend(made.get(), made.get(), NID_basic_constraints, "critical,CA:TRUE,pathlen:0") &&
      Extend(made.get(), made.get(), NID_key_usage,
             "critical,keyCertSign,cRLSign,digitalSignature") &&
      Extend(made.get(), made.get(), NID_subject_key_identifier, "hash") &&
      X509_sign(made.get(), key, EVP_sha256()) > 0;
  if (!done) return CryptoError("cannot make the certificate of " + name);
  return made;
}

Result<CertificatePtr> NewCertificate(const std::string& name, const std::string& role,
                                      const Validity& validity, EVP_PKEY* key, X509* authority,
                                      EVP_PKEY* authority_key) {
  const auto number = NewNumber();
  CertificatePtr made = number ? Draft(*number, validity, key) : nullptr;
  X509_NAME* subject = made ? X509_get_subject_name(made.get()) : nullptr;
  const bool done =
      made && AddText(subject, NID_commonName, name) &&
      AddText(subject, NID_organizationalUnitName, role) &&
      AddText(subject, NID_serialNumber, Hex(*number)) &&
      X509_set_issuer_name(made.get(), X509_get_subject_name(authority)) == 1 &&
      Extend(made.get(), authority, NID_basic_constraints, "critical,CA:FALSE") &&
      Extend(made.get(), authority, NID_key_usage, "critical,digitalSignature,keyAgreement") &&
      Extend(made.get(), authority, NID_authority_key_identifier, "keyid:always") &&
      X509_sign(made.get(), authority_key, EVP_sha256()) > 0;
  if (!done) return CryptoError("cannot make the certificate of " + name);
  return made;
}

Result<CrlPtr> NewRevocations(X509_CRL* old, X509* revoked, X509* authority,
                              EVP_PKEY* authority_key) {
  CrlPtr made(old == nullptr ? X509_CRL_new() : X509_CRL_dup(old));
  const TimePtr now(X509_gmtime_adj(nullptr, 0));
  const TimePtr before = Asn1(ValidityOf(authority).not_before);
  bool done = made && X509_CRL_set_version(made.get(), kCrlVersion2) == 1 &&
              X509_CRL_set_issuer_name(made.get(), X509_get_subject_name(authority)) == 1 &&
              X509_CRL_set1_lastUpdate(made.get(), before.get()) == 1 &&
              X509_CRL_set1_nextUpdate(made.get(), X509_get0_notAfter(authority)) == 1;
  if (revoked != nullptr && done && !IsRevoked(old, revoked)) {
    RevokedPtr entry(X509_REVOKED_new());
    done = entry && X509_REVOKED_set_serialNumber(entry.get(), X509_get_serialNumber(revoked)) &&
           X509_REVOKED_set_revocationDate(entry.get(), now.get()) == 1 &&
           X509_CRL_add0_revoked(made.get(), entry.get()) == 1;
    if (done) static_cast<void>(entry.release());  // now owned by the list
  }
  done = done && X509_CRL_sort(made.get()) == 1 &&
         X509_CRL_sign(made.get(), authority_key, EVP_sha256()) > 0;
  if (!done) return CryptoError("cannot make the list of revoked certificates");
  return made;
}

bool IsRevoked(X509_CRL* revocations, X509* certificate) {
  X509_REVOKED* entry = nullptr;
  return revocations != nullptr && X509_CRL_get0_by_cert(revocations, &entry, certificate) == 1;
}

std::string SubjectOf(const X509* certificate) {
  const BioPtr text(BIO_new(BIO_s_mem()));
  if (!text) return {};
  X509_NAME_print_ex(text.get(), X509_get_subject_name(certificate), 0, XN_FLAG_RFC2253);
  return Contents(text.get());
}

std::string NameOf(const X509* certificate) {
  return Text(certificate, NID_commonName);
}

std::string RoleOf(const X509* certificate) {
  return Text(certificate, NID_organizationalUnitName);
}

Validity ValidityOf(const X509* certificate) {
  return {FromAsn1(X509_get0_notBefore(certificate)), FromAsn1(X509_get0_notAfter(certificate))};
}

int Verify(X509* certificate, X509* authority, X509_CRL* revocations) {
  const StorePtr store(X509_STORE_new());
  const StoreContextPtr context(X509_STORE_CTX_new());
  if (!store || !context) return X509_V_ERR_OUT_OF_MEM;
  X509_STORE_add_cert(store.get(), authority);
  if (revocations != nullptr) {
    X509_STORE_add_crl(store.get(), revocations);
    X509_STORE_set_flags(store.get(), X509_V_FLAG_CRL_CHECK);
  }
  if (X509_STORE_CTX_init(context.get(), store.get(), certificate, nullptr) != 1) {
    return X509_V_ERR_UNSPECIFIED;
  }
  X509_verify_cert(context.get());
  ERR_clear_error();
  return X509_STORE_CTX_get_error(context.get());
}

Result<std::string> Sign(const std::string& document, X509* signer, EVP_PKEY* signer_key) {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;
  const BioPtr in = Reading(document);
  const BioPtr out(BIO_new(BIO_s_mem()));
  const Pkcs7Ptr signature(in && out ? PKCS7_sign(signer, signer_key, nullptr, in.get(), kFlags)
                                     : nullptr);
  const bool done = signature && BIO_reset(in.get()) == 1 &&
                    SMIME_write_PKCS7(out.get(), signature.get(), in.get(), kFlags) == 1;
  if (!done) return CryptoError("cannot sign a document");
  return Contents(out.get());
}

// Verifies with the given signer only: certificates inside the document prove nothing.
Result<std::string> Signed(const std::string& smime, X509* signer) {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_NOVERIFY | PKCS7_NOINTERN;
  const BioPtr in = Reading(smime);
  const BioPtr out(BIO_new(BIO_s_mem()));
  BIO* content = nullptr;
  const Pkcs7Ptr signature(in && out ? SMIME_read_PKCS7(in.get(), &content) : nullptr);
  const BioPtr owned(content);
  const CertificateStackPtr signers(sk_X509_new_null());
  const bool done =
      signature && content != nullptr && signers && sk_X509_push(signers.get(), signer) > 0 &&
      PKCS7_verify(signature.get(), signers.get(), nullptr, content, out.get(), kFlags) == 1;
  if (!done) return CryptoError("its signature is not valid");
  return Contents(out.get());
}

}  // namespace musher::transport::keys
