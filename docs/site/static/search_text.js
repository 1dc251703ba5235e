// Excerpts of the search are sentences: blocks of code and formulas are left out of them. No page is listed twice.
document.addEventListener("DOMContentLoaded", () => {
  if (typeof Search === "undefined") {
    return;
  }
  const perform = Search._performSearch;
  Search._performSearch = (...words) => {
    const seen = new Set(); // results are shown from the last one on: of two that look the same that one stays
    const isNew = ([page, title]) => !seen.has(`${page} ${title}`) && seen.add(`${page} ${title}`);
    return perform(...words).reverse().filter(isNew).reverse();
  };
  const whole = Search.htmlToText;
  Search.htmlToText = (html, anchor) => {
    const page = new DOMParser().parseFromString(html, "text/html");
    page.querySelectorAll(".highlight, .math, math, iframe").forEach((each) => each.remove());
    return whole(page.documentElement.outerHTML, anchor);
  };
});
