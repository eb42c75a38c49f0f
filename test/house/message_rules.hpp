#pragma once
// docs/troubleshooting.md explains every message: a row begins with the sentence as it is printed,
// "…" for what differs, and has a cause and a cure.

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// Whether `text` is `pattern`, whose "…" stand for any text, also none.
bool FitsPattern(std::string_view text, std::string_view pattern);

// Events of lifecycle/event_name.hpp and sentences of test/golden/record_texts.expected that no row
// of "Records and faults" explains; rows of an unknown event; rows without a cause or a cure.
std::vector<std::string> UnexplainedRecords(const SourceFile& page,
                                            const std::vector<SourceFile>& tree);

// Refusals of lifecycle/refusal.hpp that no row of "Refusals" explains, and rows that explain none.
std::vector<std::string> UnexplainedRefusals(const SourceFile& page,
                                             const std::vector<SourceFile>& tree);
// Refusals that no test names.
std::vector<std::string> UntestedRefusals(const std::vector<SourceFile>& tree);
// Files of lifecycle/ that put together the sentence of a refusal, which belongs into refusal.hpp.
std::vector<std::string> RefusalsElsewhere(const std::vector<SourceFile>& tree);

// Findings of test/golden/configs that no row of "Errors of a config" explains, and rows that
// explain none.
std::vector<std::string> UnexplainedFindings(const SourceFile& page,
                                             const std::vector<SourceFile>& tree);

// Codes of the machine and of the modules that "Codes" does not have in the first column of a row.
std::vector<std::string> UnexplainedCodes(const SourceFile& page,
                                          const std::vector<SourceFile>& tree);

// Sentences that no program prints, of the sections that have a sentence, a cause and a cure.
std::vector<std::string> SentencesOfNoProgram(const SourceFile& page,
                                              const std::vector<SourceFile>& tree);

}  // namespace musher::house
