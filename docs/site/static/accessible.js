// What scrolls sideways can be reached and scrolled with the keyboard, the two columns beside the text have names, and
// the page of results has a heading.
document.addEventListener("DOMContentLoaded", () => {
  for (const each of document.querySelectorAll(".highlight pre, .table-wrapper")) {
    each.tabIndex = 0;
  }
  document.querySelector("aside.sidebar-drawer")?.setAttribute("aria-label", "All pages");
  document.querySelector("aside.toc-drawer")?.setAttribute("aria-label", "This page");
  const results = document.getElementById("search-results");
  if (results !== null && document.querySelector("h1") === null) {
    const heading = document.createElement("h1");
    heading.textContent = "Search";
    results.before(heading);
  }
});
