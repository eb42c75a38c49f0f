#pragma once
// A robot's folder of keys.
//
//   identity_ca.cert      vouches for certificates        } the same for all, no secret
//   permissions_ca.cert   vouches for documents           }
//   governance.p7s        what is protected, and how      }
//   revoked.crl           certificates that count no more }
//   <name>.cert           who this is                     } one of each identity,
//   <name>.permissions    what it may do                  } no secret
//   <name>.key            its secret: 0600
//   ca/                   the keys of the two CAs: only who issues identities needs them
//
// The two CAs are apart so that nobody whose certificate the one has signed can sign permissions.

#include <string>
#include <vector>

namespace musher::transport::keys {

class KeyFolder {
 public:
  explicit KeyFolder(std::string path) : path_(std::move(path)) {}

  const std::string& path() const { return path_; }
  std::string IdentityCa() const { return path_ + "/identity_ca.cert"; }
  std::string PermissionsCa() const { return path_ + "/permissions_ca.cert"; }
  std::string Governance() const { return path_ + "/governance.p7s"; }
  std::string Revocations() const { return path_ + "/revoked.crl"; }
  std::string Certificate(const std::string& name) const { return path_ + "/" + name + ".cert"; }
  std::string Permissions(const std::string& name) const {
    return path_ + "/" + name + ".permissions";
  }
  std::string Key(const std::string& name) const { return path_ + "/" + name + ".key"; }
  std::string CaFolder() const { return path_ + "/ca"; }
  std::string IdentityCaKey() const { return CaFolder() + "/identity_ca.key"; }
  std::string PermissionsCaKey() const { return CaFolder() + "/permissions_ca.key"; }

  // The names of the identities that have a certificate here, sorted.
  std::vector<std::string> Identities() const;

 private:
  std::string path_;
};

// What can be an identity's name: that of an actuator, which ends up in file names and documents.
bool IsIdentityName(const std::string& name);

}  // namespace musher::transport::keys
