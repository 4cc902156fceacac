"""Two results side by side: do they agree, and in what do they differ?"""
