"""What `comotion run --out` writes: tables, a resistance plot, a ParaView series, a picture. See docs/outputs.md."""
