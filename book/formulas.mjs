// A preprocessor of mdBook: formulas, which stand in the sources as GitHub reads them ($`...`$ in a line, ```math in blocks), become MathML,
// so that the book needs no script, no font and no other server. A formula that is wrong ends the build.

import { readFileSync } from "node:fs";
import temml from "temml";

if (process.argv[2] === "supports") process.exit(process.argv[3] === "html" ? 0 : 1);

/** What a formula says that is none. */
const wrong = [];

function rendered(tex, isBlock, place) {
  try {
    return temml.renderToString(tex, { displayMode: isBlock, throwOnError: true, annotate: false, wrap: isBlock ? "none" : "tex" });
  } catch (error) {
    wrong.push(`${place}: ${tex}\n  ${error.message}`);
    return "";
  }
}

/** The same without what Markdown would take for its own. */
const plain = (markup) => markup.replace(/(^|>)([^<]*)/g, (_, before, text) => before + text.replace(/[\\`*_[\]|~$!]/g, (sign) => `&#${sign.codePointAt(0)};`)).replaceAll("\n", " ");

/** The formulas in lines that are no code. In a table a bar is written with a backslash, which is not part of the formula. */
function ofText(text, place) {
  for (const [other] of text.matchAll(/\\\\[([].*/g)) wrong.push(`${place}: ${other}\n  expected a formula as GitHub reads it, $\`...\`$ or a block of code in the language math`);
  return text.replace(/\$`([^`]+)`\$/g, (whole, tex, at) => {
    const line = text.slice(text.lastIndexOf("\n", at) + 1, at);
    return plain(rendered(line.trimStart().startsWith("|") ? tex.replaceAll("\\|", "|") : tex, false, place));
  });
}

/** A chapter with its formulas rendered: fenced blocks are formulas where they are `math`, and otherwise left alone. */
function ofChapter(content, place) {
  const fence = /^([ \t]*)(```+|~~~+)([^\n]*)\n([\s\S]*?)^[ \t]*\2[ \t]*$/gm;
  let [result, end] = ["", 0];
  for (const found of content.matchAll(fence)) {
    const [whole, indent, , language, body] = found;
    result += ofText(content.slice(end, found.index), place);
    result += language.trim() === "math" ? `${indent}<div class="formula">${rendered(body.trim(), true, place).replaceAll("\n", " ")}</div>` : whole;
    end = found.index + whole.length;
  }
  return result + ofText(content.slice(end), place);
}

function ofItems(items) {
  for (const { Chapter: chapter } of items) {
    if (!chapter) continue;
    chapter.content = ofChapter(chapter.content, chapter.path ?? chapter.name);
    ofItems(chapter.sub_items);
  }
}

const [, book] = JSON.parse(readFileSync(0, "utf8"));
ofItems(book.items ?? book.sections);
if (wrong.length > 0) {
  console.error(`formulas that cannot be rendered:\n${wrong.join("\n")}`);
  process.exit(1);
}
process.stdout.write(JSON.stringify(book));
