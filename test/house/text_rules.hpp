#pragma once
// What may not stand in a file, wherever it is included.

#include <map>
#include <string>
#include <vector>

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// Clocks, threads and sockets, of which pure folders know nothing.
std::vector<std::string> Impurities(const SourceFile& file);
// Calls that wait for a time instead of an event.
std::vector<std::string> Sleeps(const SourceFile& file);
// Calls of a service that answers after a switch, by a client that does not watch its controller.
std::vector<std::string> UnwatchedCalls(const SourceFile& file);
// Iterators that throw where a file or a folder vanishes while it is read, as in /proc.
std::vector<std::string> ThrowingIterators(const SourceFile& file);
// Declared functions whose name, as Settle(), has many meanings: a reader has to open them to learn
// what they do.
std::vector<std::string> VagueMethods(const SourceFile& file);
// Types named by a gerund, as Stopping: a type is a thing, a state of a state machine excepted.
// What is a thing all the same, as a Recording, is in a list there, with the reason.
std::vector<std::string> GerundTypes(const SourceFile& file);
// Sentences of comments that refer back twice, as by "that of": a reader has to find two nouns that
// are not there. Repeat the noun, or make two sentences.
std::vector<std::string> ChainedReferences(const SourceFile& file);
// Comments whose first words stand for a noun that is not there, as "Of a unit" above PathOf(). Say
// "The path of a unit".
std::vector<std::string> UnnamedSubjects(const SourceFile& file);
// Notes that something is not done.
std::vector<std::string> Leftovers(const SourceFile& file);
// "word or phrase: what to say instead" on each line, '#' begins a comment.
std::map<std::string, std::string> ReadPrivateWords(const std::string& text);
// Words and phrases for which the field has another word: in each line and in the path, also as
// parts of snake_case and CamelCase. A name with "a name that stays" is permitted as it is spelled.
std::vector<std::string> PrivateWords(const SourceFile& file,
                                      const std::map<std::string, std::string>& words);
// A header that may be included twice.
std::vector<std::string> MissingPragmaOnce(const SourceFile& file);
// A script that cannot be run as it is.
std::vector<std::string> NotExecutable(const SourceFile& file);

}  // namespace musher::house
