"""The table of `./bench`: each row does the same work with the product and with a peer, alternating, in one run."""
