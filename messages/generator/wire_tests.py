"""The wire tests of test/contract: each interface goes to a plain C program that has nothing but idlc's structs,
is compared field by field, and comes back.
"""

import cpp_headers
import idl

MADE = "// Made from the IDL in messages/ when Musher is built; do not edit."


def c_name(struct):
    return struct.dds_name.replace("::", "_")


def signature(struct, name):
    return f"MUSHER_SAME({c_name(struct)}, {name})"


def comparisons(files):
    """(header, source) of Same() for every struct."""
    names = cpp_headers.cpp_names(files)
    structs = [struct for file in files for struct in file.structs]
    include = [f'#include "musher/messages/{file.path[:-len(".idl")]}.hpp"' for file in files]
    header = [MADE, "#pragma once", "#include <musher_idl.h>", "", *sorted(include),
              '#include "musher/test/contract/fill.hpp"', '#include "musher/test/contract/wire_same.hpp"', "", "namespace musher::msg {", ""]
    header += [f"{signature(each, names[each.dds_name])};" for each in structs if not aliased(each)]
    bounds = {names[field.type.base]: field.type.bound for each in structs for field in each.own_fields
              if field.type.bound}
    header += [f"template <>\ninline constexpr std::size_t kMostItems<{name}> = {bound};"
               for name, bound in sorted(bounds.items())]
    source = [MADE, '#include "wire_comparisons.hpp"', "", "namespace musher::msg {", ""]
    for struct in structs:
        if aliased(struct):
            continue
        source.append(f"{signature(struct, names[struct.dds_name])} {{")
        source += [f"  {'SAME_ITEMS' if field.type.sequence else 'SAME'}({field.name});"
                   for field in struct.own_fields]
        source += ["}", ""]
    end = ["", "}  // namespace musher::msg", ""]
    return "\n".join(header + end), "\n".join(source + end[1:])


def aliased(struct):
    """Whether the struct is musher::msg::Empty in C++, for which there is one template."""
    return struct.empty and struct.kind == "srv"


def exchange(interface, part, names):
    struct = interface.parts[part]
    return (f"  ExchangeMessage<{c_name(struct)}, msg::{names[struct.dds_name]}>"
            f"({c_name(struct)}_desc);")


def service(interface, prefix, name):
    request, response = (c_name(interface.parts[prefix + part]) for part in ("Request", "Response"))
    return (f"  ExchangeService<{request}, {response}, msg::{name}>("
            f"{request}_desc, {response}_desc);")


def body(interface, names):
    if interface.kind == "msg":
        return [exchange(interface, "", names)]
    if interface.kind == "srv":
        return [service(interface, "", interface.cpp_name)]
    return [exchange(interface, part, names) for part in ("Goal", "Result", "Feedback", "FeedbackMessage")] + [
        service(interface, f"{part}_", f"{interface.cpp_name}::{part}") for part in ("SendGoal", "GetResult")]


def tests(files, package):
    """A test for each interface of a package."""
    names = cpp_headers.cpp_names(files)
    lines = [MADE, '#include "musher/test/contract/wire_exchange.hpp"', '#include "wire_comparisons.hpp"', "",
             f"namespace musher::transport::wire_{package}_test {{", ""]
    for interface in (each for file in files for each in idl.interfaces_of(file) if each.package == package):
        if interface.parts:
            lines += [f"TEST_F(Wire, Carries{interface.cpp_name}AsTheIdlSays) {{", *body(interface, names), "}", ""]
    return "\n".join(lines + [f"}}  // namespace musher::transport::wire_{package}_test", ""])


def sources(files):
    """{file name: text}"""
    packages = {struct.package for file in files for struct in file.structs}
    header, source = comparisons(files)
    return {"wire_comparisons.hpp": header, "wire_comparisons.cpp": source,
            **{f"wire_{package}_test.cpp": tests(files, package) for package in packages}}
