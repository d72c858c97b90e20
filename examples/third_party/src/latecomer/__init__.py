"""Reports that come late, and what one needs to study them."""
