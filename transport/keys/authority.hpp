#pragma once
// Issues a robot's identities and revokes them. Needs the folder ca/ with the CAs' keys.
//
// Threads: one at a time for a folder.

#include <string>
#include <vector>

#include "musher/lifecycle/result.hpp"
#include "musher/transport/keys/key_folder.hpp"
#include "musher/transport/keys/rights.hpp"

namespace musher::transport::keys {

struct IssueOptions {
  int days = 730;      // that a certificate and its permissions are valid; never longer than the CA
  bool force = false;  // replace what is there; the certificate before is revoked
};

// Makes the folder, its CAs, valid for ten years, and its governance. Fails where there are CAs
// already, unless forced: all identities of before are worthless then.
Result<> CreateAuthority(const KeyFolder& folder, Protection protection, bool force);

// Key, certificate and permissions of one identity. Fails where it exists, unless forced.
Result<> Issue(const KeyFolder& folder, const std::string& name, Role role,
               const IssueOptions& options);

// From now on its certificate counts no more for those who have the new revoked.crl.
Result<> Revoke(const KeyFolder& folder, const std::string& name);

struct Identity {
  std::string name;
  std::optional<Role> role;
  WallTime not_after;
  bool revoked = false;
  bool has_key = false;
};
// No secret among it.
Result<std::vector<Identity>> List(const KeyFolder& folder);

}  // namespace musher::transport::keys
