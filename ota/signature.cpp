#include "musher/ota/signature.hpp"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>

#include <array>
#include <new>

#include "musher/ota/fault.hpp"

namespace musher::ota {
namespace {

constexpr std::size_t kSignatureSize = 64;

template <auto Free>
struct Freed {
  template <class T>
  void operator()(T* object) const {
    Free(object);
  }
};
using KeyPtr = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using BioPtr = std::unique_ptr<BIO, Freed<BIO_free_all>>;
using DigestPtr = std::unique_ptr<EVP_MD_CTX, Freed<EVP_MD_CTX_free>>;

const unsigned char* Bytes(std::string_view text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

BioPtr Bio(std::string_view text) {
  return BioPtr(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

std::string Content(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return size > 0 ? std::string(data, static_cast<std::size_t>(size)) : std::string();
}

// "<what>: <libcrypto's reason>"; removes the reason from libcrypto's queue.
Error CryptoError(const std::string& what) {
  const unsigned long code = ERR_get_error();
  ERR_clear_error();
  const char* reason = code == 0 ? nullptr : ERR_reason_error_string(code);
  return {kCodeFailed, what + (reason == nullptr ? "" : std::string(": ") + reason)};
}

Result<KeyPtr> Ed25519(EVP_PKEY* read, const char* what) {
  KeyPtr key(read);
  if (!key) return CryptoError(std::string("not ") + what + " (PEM)");
  if (EVP_PKEY_get_base_id(key.get()) != EVP_PKEY_ED25519) {
    return Error{kCodeFailed, std::string("not ") + what + ": another kind of key"};
  }
  return key;
}

Result<KeyPtr> PublicKey(std::string_view pem) {
  if (pem.find("PRIVATE KEY-----") != std::string_view::npos) {
    return Error{kCodeFailed, "not a public key but a private one, which must not be on a robot"};
  }
  return Ed25519(PEM_read_bio_PUBKEY(Bio(pem).get(), nullptr, nullptr, nullptr),
                 "an Ed25519 public key");
}

// Never prompts for a password: refuses keys that have one.
int NoPassword(char*, int, int, void*) {
  return -1;
}

}  // namespace

Result<KeyPair> MakeKeyPair() {
  const KeyPtr key(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519"));
  const BioPtr secret(BIO_new(BIO_s_mem()));
  const BioPtr open(BIO_new(BIO_s_mem()));
  const bool made = key && secret && open &&
                    PEM_write_bio_PKCS8PrivateKey(secret.get(), key.get(), nullptr, nullptr, 0,
                                                  nullptr, nullptr) == 1 &&
                    PEM_write_bio_PUBKEY(open.get(), key.get()) == 1;
  if (!made) return CryptoError("no key could be made");
  return KeyPair{Content(secret.get()), Content(open.get())};
}

Result<std::string> Sign(std::string_view text, std::string_view private_pem) {
  const auto key =
      Ed25519(PEM_read_bio_PrivateKey(Bio(private_pem).get(), nullptr, NoPassword, nullptr),
              "an Ed25519 private key without a password");
  if (!key) return key.error();
  const DigestPtr context(EVP_MD_CTX_new());
  std::array<unsigned char, kSignatureSize> signature{};
  std::size_t size = signature.size();
  const bool done =
      context &&
      EVP_DigestSignInit(context.get(), nullptr, nullptr, nullptr, key.value().get()) == 1 &&
      EVP_DigestSign(context.get(), signature.data(), &size, Bytes(text), text.size()) == 1;
  if (!done) return CryptoError("the manifest cannot be signed");
  return std::string(reinterpret_cast<const char*>(signature.data()), size);
}

Result<> VerifySignature(std::string_view text, std::string_view signature,
                         std::string_view public_pem) {
  const auto key = PublicKey(public_pem);
  if (!key) return key.error();
  const DigestPtr context(EVP_MD_CTX_new());
  const bool good =
      signature.size() == kSignatureSize && context &&
      EVP_DigestVerifyInit(context.get(), nullptr, nullptr, nullptr, key.value().get()) == 1 &&
      EVP_DigestVerify(context.get(), Bytes(signature), signature.size(), Bytes(text),
                       text.size()) == 1;
  ERR_clear_error();
  if (good) return Ok();
  return FaultError(Fault::kWrongSignature,
                    "the signature does not match this manifest and this robot's key: signed with "
                    "another key, or altered");
}

Result<> CheckPublicKey(std::string_view public_pem) {
  const auto key = PublicKey(public_pem);
  return key ? Ok() : Result<>(key.error());
}

struct Sha256::Context {
  DigestPtr digest{EVP_MD_CTX_new()};
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  const bool ready =
      context_->digest && EVP_DigestInit_ex(context_->digest.get(), EVP_sha256(), nullptr) == 1;
  if (!ready) throw std::bad_alloc();
}

Sha256::~Sha256() = default;

void Sha256::Add(std::string_view bytes) {
  if (EVP_DigestUpdate(context_->digest.get(), bytes.data(), bytes.size()) != 1) {
    throw std::bad_alloc();
  }
}

std::string Sha256::Finish() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (EVP_DigestFinal_ex(context_->digest.get(), digest.data(), &size) != 1) throw std::bad_alloc();
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string hex;
  for (unsigned i = 0; i < size; ++i) {
    hex += kDigits[digest[i] >> 4U];
    hex += kDigits[digest[i] & 15U];
  }
  return hex;
}

}  // namespace musher::ota
