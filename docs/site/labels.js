// What the theme leaves to screen readers and the keyboard: a landmark for each block of code, nested lists of pages
// with equal names, and code and tables that scroll but take no focus.
const repair = () => {
  document.querySelectorAll("nav.md-code__nav").forEach((part) => part.setAttribute("role", "none"));
  document.querySelectorAll("nav.md-nav[aria-labelledby]").forEach((part, k) => {
    const title = document.getElementById(part.getAttribute("aria-labelledby"))?.textContent.trim();
    part.removeAttribute("aria-labelledby");
    part.setAttribute("aria-label", `${title}, list ${k + 1}`);
  });
  const scrolling = "pre > code:not([tabindex]), .md-typeset__scrollwrap:not([tabindex])";
  document.querySelectorAll(scrolling).forEach((part) => part.setAttribute("tabindex", "0"));
};
new MutationObserver(repair).observe(document.documentElement, {childList: true, subtree: true, attributeFilter: ["tabindex"]});
