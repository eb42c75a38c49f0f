#!/usr/bin/env python3
"""Checks a built site: every link and anchor inside of it leads somewhere, every page is reached from the front
page, and no page has a script or style inside (musher view forbids them).

    check_site.py HTML
"""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.ids, self.links, self.images, self.inline = set(), [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        if given.get("id"):
            self.ids.add(given["id"])
        if tag == "a" and given.get("name"):
            self.ids.add(given["name"])
        for name in ("href", "src"):
            if given.get(name):
                (self.links if name == "href" and tag == "a" else self.images).append(given[name])
        if tag == "style" or (tag == "script" and "src" not in given) or any(n == "style" or n.startswith("on") for n in given):
            self.inline.append(tag)


def main(root):
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in root.rglob("*.html")}
    faults, checked, reached, graph = [], 0, set(), {}
    for path, page in sorted(pages.items()):
        graph[path] = set()
        for link in page.links + page.images:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc or link.startswith("data:"):
                continue
            checked += 1
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.is_file():
                faults.append(f"{path.relative_to(root)}: a link to {link}, which does not exist")
            elif target in pages:
                graph[path].add(target)
                anchor = unquote(parts.fragment)
                if anchor and anchor not in pages[target].ids:
                    faults.append(f"{path.relative_to(root)}: a link to {link}, whose place does not exist")
        for tag in page.inline:
            faults.append(f"{path.relative_to(root)}: a {tag} inside of the page")
    waiting = [root / "index.html"]
    while waiting:
        path = waiting.pop()
        if path not in reached:
            reached.add(path)
            waiting += graph.get(path, ())
    for path in sorted(set(pages) - reached):
        if path.name != "search.html":
            faults.append(f"{path.relative_to(root)}: not reached from the front page")
    for fault in faults:
        print(f"check_site: {fault}", file=sys.stderr)
    size = sum(path.stat().st_size for path in root.rglob("*") if path.is_file())
    sources = sum(1 for path in pages if "source" in path.relative_to(root).parts[:1])
    print(f"docs: {len(pages) - sources} pages and {sources} of source files, {checked} links, {size / 1e6:.1f} MB, "
          f"{len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
