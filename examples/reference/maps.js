// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The filter of a map's page: a row stays if it has all words that were typed. Long lists of values, which are
// folded, do not count. The page's address keeps the words, so that map_c630s.html#q=torque opens filtered.

(() => {
    const box = document.getElementById("q");
    const rows = [...document.querySelectorAll("tr.register")].map(row => {
        const visible = row.cloneNode(true);
        for (const folded of visible.querySelectorAll("details")) folded.remove();
        const words = [...visible.cells].map(cell => cell.textContent);
        return {row, text: [...words, row.dataset.also].join(" ").toLowerCase()};
    });
    const bodies = [...document.querySelectorAll("table.map tbody")];

    function filter() {
        const words = box.value.toLowerCase().split(/\s+/).filter(w => w);
        let shown = 0;
        for (const {row, text} of rows) {
            row.hidden = !words.every(w => text.includes(w));
            if (!row.hidden) ++shown;
        }
        for (const body of bodies) body.hidden = !body.querySelector("tr.register:not([hidden])");
        document.getElementById("count").textContent = `${shown} of ${rows.length} registers`;
        document.getElementById("none").hidden = shown !== 0;
    }

    function decoded(text) {
        try { return decodeURIComponent(text); } catch { return text; }
    }

    // #q=WORDS filters. Any other anchor is a place on the page, which a filter must not hide.
    function follow() {
        const hash = location.hash;
        if (hash.startsWith("#q=")) {
            box.value = decoded(hash.slice(3));
            filter();
            scrollTo(0, 0);
        } else {
            const place = hash && document.getElementById(decoded(hash.slice(1)));
            const row = place && place.closest("tr.register");
            if (row && row.hidden) {
                box.value = "";
                filter();
            }
            if (place) place.scrollIntoView();
        }
    }

    box.addEventListener("input", () => {
        filter();
        const words = box.value.trim();
        history.replaceState(null, "", words ? "#q=" + encodeURIComponent(words) : location.pathname + location.search);
    });
    addEventListener("hashchange", follow);
    document.getElementById("bar").hidden = false;
    filter();
    follow();
})();
