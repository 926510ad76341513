"""Takes robots' statuses: a process of its own, so that they wait for no stream of commands and no console, nor hold those up."""
