"""The protocol between a CFD client and the motion server: messages, bytes, session, links, client."""
