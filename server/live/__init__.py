"""What goes to browsers and robots as it happens: the live hub, the streams of commands."""
