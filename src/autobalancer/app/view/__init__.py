"""The moving picture of a run in the browser: one JavaScript module, for the page and for notebooks."""
