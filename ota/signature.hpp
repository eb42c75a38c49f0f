#pragma once
// Ed25519 signatures and SHA-256, from libcrypto. signature.cpp is the only file of the controller
// that uses OpenSSL.
//
// A signature is the raw 64 bytes, so that `openssl pkeyutl -verify -rawin` can verify it, too.

#include <memory>
#include <string>
#include <string_view>

#include "musher/base/result.hpp"

namespace musher::ota {

// A new pair of keys, as PEM.
struct KeyPair {
  std::string private_pem;
  std::string public_pem;
};
Result<KeyPair> MakeKeyPair();

// The signature of `text`. An Error describes the fault of the key, never its content.
Result<std::string> Sign(std::string_view text, std::string_view private_pem);

// Ok: `signature` was made from `text` with the private key of `public_pem`.
// Fault::kWrongSignature: it was not. Any other Error: the key is invalid.
Result<> VerifySignature(std::string_view text, std::string_view signature,
                         std::string_view public_pem);

// Ok: an Ed25519 public key as PEM.
Result<> CheckPublicKey(std::string_view public_pem);

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void Add(std::string_view bytes);
  // 64 hexadecimal digits. To be called once.
  std::string Finish();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace musher::ota
