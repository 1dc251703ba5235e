// Excerpts of the search are sentences: blocks of code and formulas are left out of them.
document.addEventListener("DOMContentLoaded", () => {
  if (typeof Search === "undefined") {
    return;
  }
  const whole = Search.htmlToText;
  Search.htmlToText = (html, anchor) => {
    const page = new DOMParser().parseFromString(html, "text/html");
    page.querySelectorAll(".highlight, .math, math, iframe").forEach((each) => each.remove());
    return whole(page.documentElement.outerHTML, anchor);
  };
});
