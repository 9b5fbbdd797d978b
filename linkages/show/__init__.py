"""Results for people: figures and animations (`plots`), pages and tables (`report`), the live page (`live`).

`naming` has the names of outputs and values in words, for all of them.
"""
