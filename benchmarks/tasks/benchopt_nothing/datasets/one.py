"""The only data: a number."""

from benchopt import BaseDataset


class Dataset(BaseDataset):
    name = "One"

    def get_data(self):
        return {"number": 1}
