# Links of the Markdown to files and folders that are no pages, such as ../lifecycle or ../config/robot.toml,
# lead to a page with the file's text, or with the list of what is in the folder.

import html
import os
from pathlib import Path

from docutils import nodes
from sphinx import addnodes
from sphinx.transforms import SphinxTransform
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging

logger = logging.getLogger(__name__)

LEXERS = {".cpp": "cpp", ".hpp": "cpp", ".toml": "toml", ".py": "python", ".json": "json", ".yml": "yaml",
          ".xml": "xml", ".js": "js", ".sh": "sh", ".cmake": "cmake"}
HIDDEN = {"node_modules", "__pycache__", "build"}
LARGEST = 300_000  # bytes of a file that is shown


class FindSources(SphinxTransform):
    """Takes links to files and folders from MyST, which offers the files as downloads."""

    default_priority = 400

    def apply(self, **kwargs):
        found = [node for kind in (addnodes.pending_xref, addnodes.download_reference)
                 for node in self.document.findall(kind) if node.get("reftype") == "myst"]
        for node in found:
            target = node["reftarget"].split("#")[0]
            path = os.path.normpath(os.path.join(os.path.dirname(self.env.docname), target))
            if not target or target.endswith(".md") or path.startswith(".."):
                continue
            if not (Path(self.env.srcdir) / path).exists():
                logger.warning("there is no %s", path, location=node)
                continue
            link = addnodes.pending_xref("", refdomain=None, reftype="source", reftarget=path, refwarn=False)
            link += node.children
            node.replace_self(link)


def page_of(env, path):
    """The page of a file or a folder: a Markdown page if there is one."""
    for document in (path[:-len(".md")] if path.endswith(".md") else None, f"{path}/README"):
        if document in env.found_docs:
            return document
    return f"source/{path}"


class LinkSources(SphinxPostTransform):
    default_priority = 5

    def run(self, **kwargs):
        for node in list(self.document.findall(addnodes.pending_xref)):
            if node["reftype"] == "source":
                page = page_of(self.env, node["reftarget"])
                uri = self.app.builder.get_relative_uri(self.env.docname, page)
                node.replace_self(nodes.reference("", "", *node.children, internal=True, refuri=uri))


def children(folder):
    return sorted((p for p in folder.iterdir() if not p.name.startswith(".") and p.name not in HIDDEN),
                  key=lambda p: (p.is_file(), p.name))


def is_text(path):
    data = path.read_bytes()
    try:
        return len(data) <= LARGEST and b"\0" not in data and data.decode("utf-8") is not None
    except UnicodeDecodeError:
        return False


def shown_paths(app):
    """What pages link to; of a folder also the files that are directly in it."""
    root = Path(app.srcdir)
    linked = {node["reftarget"] for docname in app.env.found_docs
              for node in app.env.get_doctree(docname).findall(addnodes.pending_xref)
              if node["reftype"] == "source"
              and page_of(app.env, node["reftarget"]).startswith("source/")}
    inside = {str(child.relative_to(root)) for path in linked if (root / path).is_dir()
              for child in children(root / path) if child.is_file()}
    return {path for path in linked | inside
            if (root / path).is_dir() or (not path.endswith(".md") and is_text(root / path))}


def source_pages(app):
    root = Path(app.srcdir)
    shown = shown_paths(app)
    highlighter = app.builder.highlighter
    expected = {app.builder.get_outfilename(f"source/{path}") for path in shown}
    for old in Path(app.outdir, "source").rglob("*.html"):
        if str(old) not in expected:
            old.unlink()  # of an earlier build; nothing links to it any more
    for path in sorted(shown):
        here = f"source/{path}"

        def link_to(other):
            page = page_of(app.env, other)
            return app.builder.get_relative_uri(here, page) if other in shown or page in app.env.found_docs else None

        full = root / path
        if full.is_dir():
            rows = []
            for child in children(full):
                name = html.escape(child.name + ("/" if child.is_dir() else ""))
                link = link_to(str(child.relative_to(root)))
                rows.append(f'<li><a href="{link}">{name}</a></li>' if link else f"<li>{name}</li>")
            body = "<ul>" + "".join(rows) + "</ul>"
        else:
            lexer = "cmake" if full.name == "CMakeLists.txt" else LEXERS.get(full.suffix, "none")
            body = highlighter.highlight_block(full.read_text(encoding="utf-8"), lexer)
        parts = path.split("/")
        crumbs = [(part, link_to("/".join(parts[:i + 1])) if i + 1 < len(parts) else None)
                  for i, part in enumerate(parts)]
        base = app.config.source_base_url
        repository = f"{base}/{path}" if base else ""
        yield here, {"title": path, "body": body, "crumbs": crumbs, "repository": repository}, "source.html"


def setup(app):
    app.add_config_value("source_base_url", "", "html")
    app.add_transform(FindSources)
    app.add_post_transform(LinkSources)
    app.connect("html-collect-pages", source_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
