"""Results for people: figures and animations (`plots`), pages and tables (`report`), the live page (`live`)."""
