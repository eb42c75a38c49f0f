#pragma once
// Issues and revokes a robot's identities. Needs the folder ca/ with the CAs' keys.
//
// Threads: one at a time for a folder.

#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/transport/security/key_folder.hpp"
#include "musher/wire/security/permissions.hpp"

namespace musher::transport::keys {

struct IssueOptions {
  int days = 730;      // validity of a certificate and its permissions; never longer than the CA's
  bool force = false;  // replace existing files and revoke the previous certificate
};

// Creates the folder, its CAs, valid for ten years, and its governance. Fails if CAs exist, unless
// forced: all earlier identities become invalid.
Result<> CreateAuthority(const KeyFolder& folder, Protection protection, bool force);

// Creates key, certificate and permissions of one identity. Fails if it exists, unless forced.
// `extension`: the interfaces of the controller's extension; every actuator may use those that are
// not in it.
Result<> Issue(const KeyFolder& folder, const std::string& name, Role role,
               const ExtensionInterfaces& extension, const IssueOptions& options);

// Revokes its certificate: processes that have the new revoked.crl no longer accept it.
Result<> Revoke(const KeyFolder& folder, const std::string& name);

struct Identity {
  std::string name;
  std::optional<Role> role;
  WallTime not_after;
  bool revoked = false;
  bool has_key = false;
};
// Contains no secrets.
Result<std::vector<Identity>> List(const KeyFolder& folder);

}  // namespace musher::transport::keys
