# One search for English and Chinese: English words are stemmed; of Chinese, which has no spaces, every two
# neighbouring characters are a word, in the index and in what is searched for, so that no dictionary decides
# what can be found.

import re

from sphinx.search.en import SearchEnglish

HAN = r"\u3400-\u4dbf\u4e00-\u9fff\uf900-\ufaff"
WORD = re.compile(rf"[{HAN}]+|[^\W{HAN}]+")


def words(text):
    for word in WORD.findall(text):
        if len(word) > 2 and "\u3400" <= word[0] <= "\ufaff":
            yield from (word[i:i + 2] for i in range(len(word) - 1))
        else:
            yield word


class SearchEnglishAndChinese(SearchEnglish):
    lang = "en_zh"
    language_name = "English and Chinese"
    js_splitter_code = r"""
function splitQuery(query) {
  const han = "\\u3400-\\u4dbf\\u4e00-\\u9fff\\uf900-\\ufaff";
  const found = query.match(new RegExp(`[${han}]+|(?:(?![${han}])[\\p{Letter}\\p{Number}_])+`, "gu")) || [];
  return found.flatMap((word) => word.length > 2 && new RegExp(`[${han}]`, "u").test(word)
    ? Array.from({ length: word.length - 1 }, (_, i) => word.slice(i, i + 2)) : [word]);
}
"""

    def split(self, text):
        return list(words(text))


def setup(app):
    app.add_search_language(SearchEnglishAndChinese)
    app.config.html_search_language = SearchEnglishAndChinese.lang
    return {"parallel_read_safe": True, "parallel_write_safe": True}
