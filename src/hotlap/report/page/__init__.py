"""Page: a study as one HTML file that opens without network, and reads without JavaScript.

study -> standing (what is recorded) -> shown (what is flown again) -> document (plain JSON) + still (HTML) -> template.html, filled
"""
