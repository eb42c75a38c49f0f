# The tree of contents is the lists of links that a reader of the Markdown sees: in each section of
# docs/README.md, and on the pages below that list others.

import os
import re

# Pages whose lists of links are their branch of the tree; "##" headings of the first are its captions.
BRANCHES = {"docs/README", "docs/decisions/README", "docs/modules", "docs/api/README"}

ITEM = re.compile(r"^(?:-|\d+\.) \[[^]]*\]\(([^)#]+\.md)\)")


def sections(text):
    """(heading, [linked pages]) of each section; the heading of what is above the first is empty."""
    heading, links = "", []
    for line in text.splitlines():
        if line.startswith("## "):
            yield heading, links
            heading, links = line[3:].strip(), []
        elif match := ITEM.match(line):
            links.append(match[1])
    yield heading, links


def one_title(text):
    """A page with several titles has one: from the second on, headings are a level deeper."""
    lines, fence, titles = [], False, 0
    for line in text.splitlines():
        fence = fence != line.startswith("```")
        titles += not fence and line.startswith("# ")
        heading = not fence and re.match(r"#+ ", line)
        lines.append("#" + line if heading and titles > 1 else line)
    return "\n".join(lines) + "\n"


def has_titles(text):
    return len(re.findall(r"^# ", re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE), re.MULTILINE)) > 1


def is_chinese(docname):
    return docname.startswith("docs/zh/") or docname.endswith(".zh")


def add_contents(app, docname, source):
    if is_chinese(docname):  # a break of a line is no space there
        source[0] = re.sub(r"(?<=[\u3000-\u9fff\uff00-\uffef])\n(?=[\u3000-\u9fff\uff00-\uffef])", "", source[0])
    if has_titles(source[0]):
        source[0] = one_title(source[0])
    if docname not in BRANCHES:
        return
    folder = os.path.dirname(docname)
    text = source[0]
    for heading, links in sections(source[0]):
        pages = ["/" + os.path.normpath(os.path.join(folder, link))[: -len(".md")] for link in links]
        pages = [page for page in pages if page[1:] in app.env.found_docs]
        if pages:
            caption = f":caption: {heading}\n" if docname == app.config.root_doc and heading else ""
            text += f"\n```{{toctree}}\n:hidden:\n{caption}\n" + "\n".join(pages) + "\n```\n"
    source[0] = text


def write_start(app, error):
    if error is None and app.builder.format == "html":
        start = app.builder.get_target_uri(app.config.root_doc)
        with open(os.path.join(app.outdir, "index.html"), "w", encoding="utf-8") as page:
            page.write(f'<!doctype html>\n<meta charset="utf-8">\n<title>{app.config.project}</title>\n'
                       f'<meta http-equiv="refresh" content="0; url={start}">\n<a href="{start}">{start}</a>\n')


def set_language(app, pagename, templatename, context, doctree):
    if is_chinese(pagename):
        context["language"] = "zh-CN"


def setup(app):
    app.connect("source-read", add_contents)
    app.connect("html-page-context", set_language)
    app.connect("build-finished", write_start)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
