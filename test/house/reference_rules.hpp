#pragma once
// The lists of docs/reference.md and docs/api/python.md agree with the code.

#include "musher/test/house/source_tree.hpp"

namespace musher::house {

// The text of the section "## <title>", up to the next section; empty if there is none.
std::string SectionOf(const SourceFile& page, const std::string& title);

// Environment variables MUSHER_… that a program reads or sets and the page does not name, and those
// that the page names and no program has.
std::vector<std::string> WrongVariables(const SourceFile& page,
                                        const std::vector<SourceFile>& tree);

// Keys and modules of base/code.hpp, and modules of cyberdog/codes/module_codes.hpp, that the
// section "Codes" lacks or names with another number, and those it names that are not there.
std::vector<std::string> WrongCodes(const SourceFile& page, const SourceFile& header,
                                    const SourceFile& cyberdog);

// Topics and services musher/… of the wire and the controller that the table in "Topics and
// services" lacks, those it names that no program has, and rows with a type that is in no IDL file.
std::vector<std::string> WrongTopicsAndServices(const SourceFile& page,
                                                const std::vector<SourceFile>& tree);

// Names in the __all__ of the Python package's public modules (musher, musher.fsm, …) that no
// directive {python_reference} of the page has.
std::vector<std::string> PythonNamesOutsideTheReference(const SourceFile& page,
                                                        const std::vector<SourceFile>& tree);

}  // namespace musher::house
