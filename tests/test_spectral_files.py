"""Spectral files in the formats of instruments and programs, written by hand: read or refused."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import renderer
from renderer.colour.spectrum import read_lamp, read_reflectance, read_spectrum

NM = np.array([400.0, 500, 600, 700])
POWER = np.array([0.1, 0.4, 0.9, 0.5])


@pytest.fixture
def read(tmp_path):
    """The samples of a file with this content, as a lamp's."""

    def reader(content, name="lamp.csv", column="", kind="a lamp's power", encoding="utf-8"):
        data = content if isinstance(content, bytes) else content.encode(encoding)
        (tmp_path / name).write_bytes(data)
        return read_spectrum(tmp_path / f"{name}{column}", "FILE", kind)

    return reader


def rows(separator=",", point=".", order=(0, 1, 2, 3), end="\n", form="{:g}"):
    """The samples, one a line."""
    cells = [[form.format(x).replace(".", point) for x in pair] for pair in zip(NM, POWER, strict=True)]
    return end.join(separator.join(cells[k]) for k in order) + end


SEKONIC = (
    "Date Saved,1/2/2020 10:11\nMemo,a lamp\nCCT [K],4000\nIlluminance [lx],1234\n"
    "Peak Wavelength [nm],600\n"
    + "".join(f"Spectral Data {nm:g}[nm],{x:.4f}\n" for nm, x in zip(NM, POWER, strict=True))
)
FORMS = {
    "no header": rows(),
    "space": rows(" "),
    "many spaces": "  " + rows("     ").replace("\n", "  \n  "),
    "tab": "nm\tW\n" + rows("\t"),
    "semicolon, decimal commas": "Wavelength [nm];Power [W/nm]\n" + rows(";", ","),
    "tab, decimal commas": rows("\t", ","),
    "space, decimal commas": rows("  ", ",", form="{:.4f}"),
    "comma and space": rows(", "),
    "comma and tab": "wavelength,\tpower\n" + rows(",\t"),
    "tab and comma": rows("\t,"),
    "comma and space, decimal commas": rows(", ", ","),
    "trailing comma": "wavelength_nm,power,\n" + rows().replace("\n", ",\n"),
    "several header lines": "Name,my lamp\nDate,2020-01-01\nwavelength,power\n" + rows(),
    "units below names": "Wavelength,Power\n[nm],[W/nm]\n" + rows(),
    "descending": rows(order=(3, 2, 1, 0)),
    "shuffled": rows(order=(2, 0, 3, 1)),
    "comments": "# made by hand\n# nm, W\n" + rows() + "# the end\n",
    "comment amid": rows().replace("600", "// half way\n600"),
    "old Mac line ends": rows(end="\r"),
    "quoted": "\n".join(f'"{line.replace(",", chr(34) + "," + chr(34))}"' for line in rows().split()),
    "units in cells": "".join(f"{nm:g}nm\t{x:g}\n" for nm, x in zip(NM, POWER, strict=True)),
    "counted": "No.,Wavelength,Power\n"
    + "".join(f"{k},{line}\n" for k, line in enumerate(rows().split(), 1)),
    "micrometres": "wavelength [µm],power\n0.4,0.1\n0.5,0.4\n0.6,0.9\n0.7,0.5\n",
    "in one row": "Wavelength,"
    + ",".join(f"{nm}" for nm in range(400, 701, 25))
    + "\nmine,"
    + ",".join(f"{x:g}" for x in np.interp(range(400, 701, 25), NM, POWER)),
    "Sekonic": SEKONIC,
    "Sekonic, 5 and 1 nm": SEKONIC
    + "".join(f"Spectral Data {nm}[nm],{np.interp(nm, NM, POWER):.4f}\n" for nm in range(400, 701, 50)),
    "UPRtek": "Model Name\tMK350\nTime\t2020/01/02\nCCT\t4000\nλp(nm)\t600\n"
    + "".join(f"{nm:g}nm\t{x:g}\n" for nm, x in zip(NM, POWER, strict=True)),
    "LI-COR": "Model Name\tLI-180\nPPFD\t12.3\nI-Time(ms)\t100\n"
    + "".join(f"{nm:g}nm\t{x:.6e}\n" for nm, x in zip(NM, POWER, strict=True)),
    "Avantes": "Integration time: 100,00 ms\nAverage: 10 scans\n\nWave   ;Irradiance\n[nm]   ;[µW/cm²/nm]\n\n"
    + "".join(
        f"{nm:7.3f};{x:9.5f}\n".replace(".", ",") for nm, x in zip(NM, POWER, strict=True)
    ),
    "Avantes, padded": "Integration time: 100.00 ms\nData measured with spectrometer name: 0804016U1"
    + "\0" * 40 + "\nWave   ;Sample\n[nm]   ;[counts]\n" + rows(";", form="{:.4f}"),
    "JCAMP-DX": "##TITLE= EXPORTED: mine\n##JCAMP-DX= 5 $$ made by hand\n##XUNITS= NANOMETERS\n"
    "##YUNITS= COUNTS\n##XFACTOR= 1.0\n##YFACTOR= 0.5\n##NPOINTS= 4\n##XYPOINTS= (XY..XY)\n"
    + "".join(f"{nm:.2f}, {2 * x:.3f}\n" for nm, x in zip(NM, POWER, strict=True)) + "##END=\n",
    "OceanView": "Data from x.txt Node\n\nDate: Thu Jan 02\nUser: me\nSpectrometer: USB\n"
    "Integration Time (sec): 1.000000E-1\nNumber of Pixels in Spectrum: 4\n"
    ">>>>>Begin Spectral Data<<<<<\n" + rows("\t", form="{:.3f}") + ">>>>>End Spectral Data<<<<<\n",
    "ASD": "Wavelength\tlamp00001.asd\n" + rows("\t"),
    "Argyll .sp": 'SPECT  \n\nDESCRIPTOR "x"\nKEYWORD "SPECTRAL_BANDS"\nSPECTRAL_BANDS "4"\n'
    'SPECTRAL_START_NM "400.0"\nSPECTRAL_END_NM "700.0"\nSPECTRAL_NORM "1.000000"\n'
    "NUMBER_OF_FIELDS 4\nBEGIN_DATA_FORMAT\nSPEC_400 SPEC_500 SPEC_600 SPEC_700\nEND_DATA_FORMAT\n"
    "NUMBER_OF_SETS 1\nBEGIN_DATA\n0.1 0.4 0.9 0.5\nEND_DATA\n",
    "X-Rite": "CGATS.17\nORIGINATOR\t\"x\"\nNUMBER_OF_FIELDS\t6\nBEGIN_DATA_FORMAT\n"
    "SAMPLE_ID\tSAMPLE_NAME\tnm400\tnm500\tnm600\tnm700\nEND_DATA_FORMAT\nNUMBER_OF_SETS\t1\n"
    'BEGIN_DATA\n1\t"my lamp"\t0.1\t0.4\t0.9\t0.5\nEND_DATA\n',
    "CGATS pairs": "CGATS.17\nBEGIN_DATA_FORMAT\nSAMPLE_ID "
    + "SPECTRAL_NM SPECTRAL_DEC " * 4
    + "\nEND_DATA_FORMAT\nBEGIN_DATA\n1 400 0,1 500 0,4 600 0,9 700 0,5\nEND_DATA\n",
    "TM-27": '<?xml version="1.0"?><IESTM2714 xmlns="http://www.ies.org/iestm2714" version="1.0"><Header>'
    "<Manufacturer>x</Manufacturer></Header><SpectralDistribution><SpectralQuantity>radiance"
    "</SpectralQuantity><BandwidthFWHM>Unknown</BandwidthFWHM>"
    "<BandwidthCorrected>perhaps</BandwidthCorrected>"
    + "".join(
        f'<SpectralData wavelength="{nm:g}">{x:g}</SpectralData>' for nm, x in zip(NM, POWER, strict=True)
    )
    + "</SpectralDistribution></IESTM2714>",
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_every_form_is_the_same_lamp(read, form, encoding):
    found = read(FORMS[form], encoding=encoding)
    assert np.interp(NM, found.nm, found.values) == pytest.approx(POWER, rel=1e-6)
    assert (found.nm[0], found.nm[-1]) == (400, 700)


def test_latin_1(read):
    text = "Größe;°\nWellenlänge [nm];Leistung [µW]\n" + rows(";", ",")
    assert read(text, encoding="latin-1").values == pytest.approx(POWER)


SEVERAL = "Wave,Sample,Dark,Reference\n" + "".join(f"{nm:g},{x:g},0,{2 * x:g}\n" for nm, x in
                                                   zip(NM, POWER, strict=True))
SAMPLES = ("CTI3\nSPECTRAL_NORM \"100.0\"\nBEGIN_DATA_FORMAT\nSAMPLE_ID RGB_R SPEC_400 SPEC_500 SPEC_600 "
           "SPEC_700\n"
           "END_DATA_FORMAT\nBEGIN_DATA\nA1 0.0 10 40 90 50\nA2 100.0 20 80 90 50\nEND_DATA\n")


GAPS = "nm,Seen,S\n" + "".join(f"{nm:g},{x:g},{'' if nm > 650 else 1}\n"
                             for nm, x in zip(NM, POWER, strict=True))
"""The second of its spectra stops at 600 nm."""
COUNTED = "wavelength,1,2,3\n" + "".join(f"{nm:g},7,{x:g},8\n" for nm, x in zip(NM, POWER, strict=True))
JCAMP = "##TITLE=x\n##JCAMP-DX=5\n##XUNITS=NANOMETERS\n" + "".join(
    f"##TITLE=x: {name}\n##XYPOINTS=(XY..XY)\n{rows(', ', ',')}##END=\n" for name in ("mine", "dark"))


@pytest.mark.parametrize(("content", "column", "scale"), [
    (SEVERAL, "#2", 1), (SEVERAL, "#Sample", 1), (SEVERAL, "#reference", 2), (SEVERAL, "#4", 2),
    (SAMPLES, "#1", 1), (SAMPLES, "#A1", 1), (GAPS, "#2", 1), (GAPS, "#Seen", 1), (COUNTED, "#2", 1),
    (JCAMP, "#mine", 1), (JCAMP, "#1", 1)])
def test_one_of_several_is_chosen_by_number_or_name(read, content, column, scale):
    assert read(content, column=column).values == pytest.approx(scale * POWER)


@pytest.mark.parametrize(("content", "column", "said"), [
    (SEVERAL, "", "3 spectra: #2 Sample, #3 Dark, #4 Reference"), (SEVERAL, "#5", "no spectra named '5'"),
    (SEVERAL, "#x", "no spectra named"), (SAMPLES, "", "2 spectra: #1 A1, #2 A2"),
    ("nm\tW\n400\t850\n450\t1,250\n500\t990\n700\t700\n", "", "1,250' in line 3"),
    ('nm,W\n400,"850"\n450,"1,250"\n700,"700"\n', "", "1,250' in line 3"),
    ("400;1,250\n500;1,375\n700;2,500\n", "", "may be 1.250 or 1250"),
    ("400;1.250,5\n500;1,375.2\n700;2,5\n", "", "both"),
    ("400,0,1\n500,0,4\n700,0,5\n", "", "2 spectra"),
    (GAPS, "", "2 spectra: #2 Seen, #3 S"), (GAPS.replace("500,0.4", "500,"), "#2", "no number at 500 nm"),
    (GAPS.replace("500,0.4", "500,x"), "#3", "'x' in line 3, column 2"),
    (COUNTED, "", "3 spectra: #1, #2, #3"), (COUNTED, "#4", "no spectra named '4'"),
    (JCAMP, "", "2 spectra: #1 mine, #2 dark"), (JCAMP.replace("(XY..XY)", "(X++(Y..Y))"), "", "only pairs"),
    (JCAMP.replace("NANOMETERS", "1/CM"), "#1", "must be NANOMETERS"),
    (JCAMP.replace("500, 0,4", "500, 0,4; 510, 0,4"), "#1", "one pair a line"),
    ("##JCAMP-DX=5\n##END=\n", "", "no ##XYPOINTS"),
    ("400,0.1\n500,abc\n600,0.9\n700,0.5\n", "", "line 2"),
    ("400,0.1\n500,0.4\n600,\n700,0.5\n", "", "line 3"),
    ("400,0.1\n500,nan\n600,0.9\n700,0.5\n", "", "line 2"),
    ("400,0.1\n500,0.4\n500,0.9\n700,0.5\n", "", "500 nm twice"),
    ("400,0.1\n500,0.4\n600,0.5\n\nother\n400,0.9\n500,0.9\n", "", "line 6"),
    ("just words\n", "", "no rows of numbers"), ("", "", "no rows of numbers"),
    ("wavenumber [cm^-1],x\n20000,1\n18000,1\n16000,2\n", "", "nm or µm"),
    ("0.4,0.1\n0.5,0.2\n", "", "nanometres"),
    ("BEGIN_DATA_FORMAT\nSAMPLE_ID LAB_L\nEND_DATA_FORMAT\nBEGIN_DATA\n1 50\nEND_DATA\n", "", "no spectra"),
    ("BEGIN_DATA_FORMAT\nSPEC_400 SPEC_500\nEND_DATA_FORMAT\nBEGIN_DATA\n1\nEND_DATA\n", "", "1 values in "
                                                                                             "line 5"),
    ("BEGIN_DATA_FORMAT\nSPEC_400 SPEC_500\n", "", "cut short"),
    ("<a/>", "", "IESTM2714"), ("<IESTM2714>", "", "not XML"),
    ('<IESTM2714><SpectralDistribution><SpectralData>1</SpectralData></SpectralDistribution></IESTM2714>', "",
     "wavelength ''"),
    ('<?xml version="1.0" encoding="nonsense"?><IESTM2714/>', "", "'nonsense', which is none"),
    ('<!DOCTYPE x [<!ENTITY a "b">]><IESTM2714/>', "", "document type"),
    (b"\x89PNG\0\0\1", "", "zero bytes")])
def test_ambiguous_files_are_refused(read, content, column, said):
    with pytest.raises(renderer.InputError, match=said) as refused:
        read(content, column=column)
    assert str(refused.value).startswith("FILE: lamp.csv")
    assert "\n" not in str(refused.value)


def test_thousands_that_can_be_nothing_else_are_read(read):
    assert read("400\t850\n500\t1,250,000\n700\t700\n").values.tolist() == [850, 1250000, 700]
    assert read("400\t850.5\n500\t1,250.5\n700\t700\n").values.tolist() == [850.5, 1250.5, 700]
    assert read("400;1.250,5\n500;2.000,25\n700;3,5\n").values.tolist() == [1250.5, 2000.25, 3.5]


def test_a_reflectance_in_per_cent_says_so_in_its_header(tmp_path):
    (tmp_path / "p.csv").write_text("Wavelength [nm],Reflectance [%]\n400,10\n700,50\n")
    assert read_reflectance(tmp_path / "p.csv", "FILE").values == pytest.approx([0.1, 0.5])
    (tmp_path / "p.csv").write_text("Wavelength [nm],Reflectance\n400,10\n700,50\n")
    with pytest.raises(renderer.InputError, match="Divide percentages"):
        read_reflectance(tmp_path / "p.csv", "FILE")


def test_a_column_ends_where_its_numbers_do(read):
    found = read(GAPS, column="#S")
    assert (found.nm.tolist(), found.values.tolist()) == ([400, 500, 600], [1, 1, 1])


def test_noise_where_nothing_is_seen_is_left_out(tmp_path):
    noisy = "190,-40\n250,1e6\n370,0.2\n400,0.1\n700,0.5\n790,0.4\n900,-7\n"
    (tmp_path / "p.csv").write_text(noisy)
    assert read_reflectance(tmp_path / "p.csv", "FILE").nm.tolist() == [370, 400, 700, 790]
    lamp = noisy.replace("250,1e6", "350,0").replace("900,-7", "831,0")
    (tmp_path / "p.csv").write_text(lamp)
    assert read_lamp(tmp_path / "p.csv", "FILE").nm.tolist() == [350, 370, 400, 700, 790, 831]
    (tmp_path / "p.csv").write_text(noisy.replace("0.1", "-0.1"))
    with pytest.raises(renderer.InputError, match=r"-0\.1 at 400 nm"):
        read_reflectance(tmp_path / "p.csv", "FILE")


def test_a_quantity_that_tm_27_has_not_says_nothing(read):
    assert read(FORMS["TM-27"].replace("radiance", "W/nm")).values == pytest.approx(POWER)
    with pytest.raises(renderer.InputError, match="'reflectance', which is not a lamp's power"):
        read(FORMS["TM-27"].replace("radiance", "Reflectance"))


def test_noise_of_a_lamp_is_cut_off(tmp_path):
    (tmp_path / "p.csv").write_text("400,-0.015\n500,1\n700,0.5\n")
    assert read_lamp(tmp_path / "p.csv", "FILE").values.tolist() == [0, 1, 0.5]


def test_scenes_name_one_of_several_spectra(room_file, tmp_path):
    (tmp_path / "paints.csv").write_text("nm,red,blue\n400,0.1,0.6\n700,0.7,0.2\n")
    (tmp_path / "lamps.txt").write_text("nm\ta\tb\n400\t0.1\t0.6\n700\t0.7\t0.2\n")
    scene = room_file({"spectrum": "paints.csv#blue"}, luminaires=[
        {"shape": "point", "center": [2, 2, 2], "flux": 100.0, "spectrum": "lamps.txt#2"}])
    assert scene.materials[0].spectrum.values.tolist() == [0.6, 0.2]
    assert scene.lamps[0].values == pytest.approx([1 / 7, 1])


WORDS = ["nan", "1,5", "0,25", "1,250", "1.250,5", "", " ", "nm", "[nm]", "400nm", "#", '"', "1e400", "٣",
         "Wavelength", "BEGIN_DATA", "BEGIN_DATA_FORMAT", "SPEC_400 SPEC_500", "END_DATA", "END_DATA_FORMAT",
         "<", "<IESTM2714>"]
CELLS = st.one_of(st.floats(-10, 3000).map(str), st.integers(300, 800).map(str), st.sampled_from(WORDS))
TABLES = st.lists(st.lists(CELLS, max_size=5), max_size=14)


def check_read_or_refused(path, content):
    path.write_bytes(content)
    for read in (read_lamp, read_reflectance):
        said, found = "", None
        try:
            with warnings.catch_warnings(action="error"):
                found = read(path, "FILE")
        except renderer.InputError as refused:
            said = str(refused)
        assert "\n" not in said
        if found is None:
            continue
        assert (np.diff(found.nm) > 0).all()
        assert np.isfinite(found.values).all()
        assert found.values.min() >= 0


@settings(max_examples=150, deadline=None)
@given(table=TABLES, separator=st.sampled_from([",", ";", "\t", " ", ", "]))
def test_made_up_tables_are_read_or_refused(tmp_path_factory, table, separator):
    text = "\n".join(separator.join(row) for row in table)
    check_read_or_refused(tmp_path_factory.getbasetemp() / "made-up.csv", text.encode())


CHANGES = st.lists(st.tuples(st.floats(0, 1), st.integers(0, 4), st.binary(max_size=4)), max_size=5)


def changed(data, changes):
    for place, length, noise in changes:
        k = int(place * len(data))
        data = data[:k] + noise + data[k + length:]
    return data


@settings(max_examples=150, deadline=None)
@given(form=st.sampled_from(sorted(FORMS)), changes=CHANGES)
def test_mutated_files_are_read_or_refused(tmp_path_factory, form, changes):
    path = tmp_path_factory.getbasetemp() / "mutated.csv"
    check_read_or_refused(path, changed(FORMS[form].encode(), changes))


@pytest.mark.slow
@pytest.mark.fuzzing
@settings(max_examples=60_000, deadline=None)
@given(form=st.sampled_from(sorted(FORMS)), changes=CHANGES, table=TABLES)
def test_five_minutes_of_files_are_read_or_refused(tmp_path_factory, form, changes, table):
    check_read_or_refused(tmp_path_factory.getbasetemp() / "long.csv", changed(FORMS[form].encode(), changes))
    check_read_or_refused(tmp_path_factory.getbasetemp() / "long.csv",
                          "\n".join(";".join(row) for row in table).encode())
