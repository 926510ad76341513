"""Robots that speak GPSS over Redis by themselves (spec gpss; the documents are those of `protocol.gpss`)."""
