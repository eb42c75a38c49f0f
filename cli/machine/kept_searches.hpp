#pragma once
// The finished searches of proofs that were interrupted: `musher prove --resume` does not make them
// again. A file for each config, its rules and this program, in the user's cache:
//
//   musher prove 2
//   <key>
//   <from> <to> <faults> <states> <transitions> <ends> <ms> <rules> <three numbers of each rule> …
//       <rules with a time> <two numbers of each> …       in the same line
//   sum <16 hexadecimal digits, of all above>
//
// A search is whole, or not in the file. Where the file is damaged, or of another key, none of it
// counts. Its sum detects damage; it is no protection against deliberate changes: a folder that
// another user than this one and root can write to is refused.
//
// Proofs of one config at the same time share the file: each reads it again before it replaces or
// removes it. What another writes within that moment is lost, and is searched again.
//
// Waits for the disk. Threads: one.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/search/proof.hpp"

namespace musher::cli {

// What the searches of a proof depend on, besides the state, the target and the number of faults
// that each has: the version and the bytes of this program and of Musher's libraries in it, the
// text of the config, the rules and whether another machine takes part. 64 hexadecimal digits.
// Error: a file of this program cannot be read.
Result<std::string> ProofKey(const MachineConfig& config, const search::ProofOptions& proof);

// How many rules of the user a proof has.
struct RuleCounts {
  std::size_t stable = 0;
  std::size_t timed = 0;
};

// The content of the file, and the searches in it. Error: why none of them counts.
std::string KeptText(const std::string& key, const std::vector<search::ProvedTask>& searches);
Result<std::vector<search::ProvedTask>> ReadKept(std::string_view text, const std::string& key,
                                                 const RuleCounts& rules);

class KeptSearches {
 public:
  // Those of this proof in $XDG_CACHE_HOME/musher/prove, or ~/.cache/musher/prove. Error: this
  // program cannot be read, its user has no home folder, or another user can write to the folder.
  static Result<KeptSearches> Open(const MachineConfig& config, const search::ProofOptions& proof);

  const std::string& file() const { return file_; }
  // Of earlier runs; none: there is no file, or it does not count.
  const std::vector<search::ProvedTask>& earlier() const { return earlier_; }
  // Why the file does not count; empty: it does, or there is none.
  const std::string& damage() const { return damage_; }

  // Writes a file with these searches, with the ones of earlier runs, and with what another proof
  // has written meanwhile. Error: it cannot be written.
  Result<> Keep(const std::vector<search::ProvedTask>& finished);
  // A proof has ended that made or used these. The file stays if it has others: those of more
  // faults, or from other states.
  void Remove(const std::vector<search::ProvedTask>& used);

 private:
  KeptSearches() = default;
  // Those in the file now. Error: why none of them counts.
  Result<std::vector<search::ProvedTask>> Read() const;

  std::string key_;
  std::string file_;
  RuleCounts rules_;  // of the proof
  std::string damage_;
  std::vector<search::ProvedTask> earlier_;
};

}  // namespace musher::cli
