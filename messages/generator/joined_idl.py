"""All IDL in one file for idlc: without comments, and without the annotations that only this generator reads."""

import idl


def joined(files):
    lines = ["// Made from the IDL in messages/ when Musher is built; do not edit."]
    for file in files:
        for declared in file.structs:
            lines.append(f"module {declared.package} {{ module {declared.kind} {{ module dds_ {{")
            lines.append(f"  @final struct {declared.name}_ {{")
            lines += [f"    {type_text(field.type)} {escaped(field.name)}{array(field.type)};"
                      for field in declared.fields]
            lines += ["  };", "}; }; };"]
    return "\n".join(lines) + "\n"


def type_text(of):
    base = f"string<{of.string_bound}>" if of.string_bound else of.base
    if not of.sequence:
        return base
    return f"sequence<{base}, {of.bound}>" if of.bound else f"sequence<{base}>"


def escaped(name):
    """IDL accepts its keywords as names after a '_', which is no part of the name."""
    return f"_{name}" if name.lower() in idl.KEYWORDS else name


def array(of):
    return f"[{of.length}]" if of.length else ""
