"""The documentation as a site of HTML pages.

``python -m tools.site [FOLDER]`` copies the pages, with the pictures and files that they link, into a
folder of their own, adds a gallery of the cases and the reference of the Python package, and has MkDocs
make the site in FOLDER (by default ``build/site``). The pages in the repository stay plain Markdown, which
any host of repositories shows.
"""
