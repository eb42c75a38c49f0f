#pragma once
// A robot's folder of keys.
//
//   identity_ca.cert      verifies certificates         } the same for all, not secret
//   permissions_ca.cert   verifies signed documents     }
//   governance.p7s        what is protected, and how    }
//   revoked.crl           revoked certificates          }
//   <name>.cert           certificate                   } one for each identity,
//   <name>.permissions    its permissions               } not secret
//   <name>.key            its private key: 0600
//   ca/                   the keys of the two CAs: only needed to issue identities
//
// There are two CAs so that no holder of a certificate of the first can sign permissions.

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

// Whether `name` is valid for an identity: like an actuator's name, since file names and documents
// contain it.
bool IsIdentityName(const std::string& name);

}  // namespace musher::transport::keys
