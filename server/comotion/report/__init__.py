"""What `comotion report` measures: a study per question, a file per study; tables and figures of what they found."""
