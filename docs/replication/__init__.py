"""Programs that compute the pages of the replicated sources; they use `linkages` and `optim`, nothing uses them."""
