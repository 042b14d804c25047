#include "gvx/io/label_table_file.h"

#include <gtest/gtest.h>

#include "gvx/io/volume_test_support.h"

namespace gvx::io::test {
namespace {

Result<scene::LabelTable> read(const std::string& text) {
  const std::string path = temporary_path("labels.txt");
  write_file(path, text);
  return read_label_table(path);
}

void expect_error(const std::string& text, const std::string& part) {
  const auto table = read(text);
  ASSERT_FALSE(table.ok()) << text;
  EXPECT_NE(table.error().message.find("labels.txt: "), std::string::npos);
  EXPECT_NE(table.error().message.find(part), std::string::npos) << table.error().message;
  EXPECT_EQ(table.error().message.find('\n'), std::string::npos);
}

Vec3d bytes(double r, double g, double b) {
  return Vec3d(r, g, b) / Vec3d(255.0);
}

TEST(LabelTableFile, reads_freesurfer_tables) {
  const auto table = read(
                         "#$Id: a table\n\n#No. Label Name:        R   G   B   A\n"
                         "0   Unknown              0   0   0   0\r\n"
                         "17  Left-Region          220 216 20  0\n"
                         "53  Right-Region         220 216 30  255\n"
                         "11101 no_fourth          23  220 60\n")
                         .value();
  ASSERT_EQ(table.size(), 4u);
  EXPECT_EQ(table.at(17), (scene::LabelEntry{"Left-Region", bytes(220, 216, 20), 1}));
  EXPECT_EQ(table.at(53).opacity, 0);
  EXPECT_EQ(table.at(11101), (scene::LabelEntry{"no_fourth", bytes(23, 220, 60), 1}));
}

TEST(LabelTableFile, reads_slicer_tables_whose_fourth_number_is_opacity) {
  const auto table = read("0 background 0 0 0 0\n1 tissue 128 174 128 255\n2 bone 241 214 145 255\n").value();
  EXPECT_EQ(table.at(0).opacity, 0);
  EXPECT_EQ(table.at(1).opacity, 1);
  EXPECT_EQ(table.at(2).color, bytes(241, 214, 145));
}

TEST(LabelTableFile, reads_itk_snap_descriptions) {
  const auto table = read(
                         "################\n# IDX -R- -G- -B- -A-- VIS MSH LABEL\n"
                         "    0     0    0    0        0  0  0    \"Clear Label\"\n"
                         "    1   255    0    0        1  1  1    \"Label 1\"\n"
                         "    4     0    0  255      0.5  1  0    \"left, upper\"\n"
                         "    5     0  255  255        1  0  0    \"unseen\"\n")
                         .value();
  ASSERT_EQ(table.size(), 4u);
  EXPECT_EQ(table.at(1), (scene::LabelEntry{"Label 1", bytes(255, 0, 0), 1}));
  EXPECT_EQ(table.at(4), (scene::LabelEntry{"left, upper", bytes(0, 0, 255), 0.5}));
  EXPECT_EQ(table.at(5).opacity, 0);
}

TEST(LabelTableFile, reads_names_alone) {
  const auto table = read("1 Precentral_L 2001\n2 Precentral_R\n").value();
  EXPECT_EQ(table.at(1), (scene::LabelEntry{"Precentral_L"}));
  EXPECT_EQ(table.at(2), (scene::LabelEntry{"Precentral_R"}));
}

TEST(LabelTableFile, reads_tsv_and_csv_by_the_names_of_their_columns) {
  const auto tsv =
      read("\xef\xbb\xbfindex\tname\tabbreviation\tcolor\n1\tGray Matter\tGM\t#ff53BB\n2\tWhite\tWM\tn/a\n")
          .value();
  EXPECT_EQ(tsv.at(1), (scene::LabelEntry{"Gray Matter", bytes(255, 0x53, 0xbb), 1}));
  EXPECT_EQ(tsv.at(2), (scene::LabelEntry{"White"}));
  const auto csv = read("Name,ID,R,G,B\n\"a, \"\"b\"\"\",7,1,2,3\n").value();
  EXPECT_EQ(csv.at(7), (scene::LabelEntry{"a, \"b\"", bytes(1, 2, 3), 1}));
  EXPECT_EQ(read("index\tname\n3\tthree\n").value().at(3), (scene::LabelEntry{"three"}));
}

TEST(LabelTableFile, errors_name_the_line_and_what_was_expected) {
  expect_error("", "holds none");
  expect_error("# nothing\n\n", "holds none");
  expect_error("hello world\n", "line 1: expected NUMBER NAME RED GREEN BLUE");
  expect_error("1 a 1 2 3\n\n-2 b 1 2 3\n", "line 3: expected a label, a whole number from 0, found");
  expect_error("1 a 1 2 256\n", "line 1: expected red, green and blue as whole numbers from 0 to 255, found");
  expect_error("1 a 1 2 3 900\n", "line 1: expected a fourth number from 0 to 255");
  expect_error("1 1 2 3 7 1 1 \"a\"\n", "line 1: expected an opacity from 0 to 1");
  expect_error("1 1 2 3 1 x 1 \"a\"\n", "line 1: expected a visibility, 0 or 1");
  expect_error("name\tcolor\nx\t#112233\n", "line 1: expected columns index, name and color");
  expect_error("index,color\n1,red\n", "line 2: expected a colour as #rrggbb, found");
  expect_error("index,name\n,a\n", "line 2: expected a label");
  expect_error(std::string("1 a\0 1 2 3\n", 11), "a text, this is not");
  expect_error("5000000000 a 1 2 3\n", "line 1: expected a label");
  EXPECT_NE(read_label_table(temporary_path("missing.txt")).error().message.find("cannot open"),
            std::string::npos);
  EXPECT_FALSE(read_label_table(testing::TempDir()).ok());
}

TEST(LabelTableFile, broken_lines_are_errors_that_name_them) {
  expect_error("index,name,color\n1,\"a,#112233\n", "line 2: expected a closing quotation mark");
  expect_error("1 255 0 0 1 1 1 \"A\n", "line 1: expected a closing quotation mark");
  expect_error("1 \"A\n", "line 1: expected a closing quotation mark");
  expect_error("index,name,color\n1,a\n", "line 2: expected 3 fields, as line 1 has, found 2");
  expect_error("index,name,r\n1,a,2\n", "line 1: expected all of the columns r, g and b, or none");
  expect_error("index,name,r,g,b\n1,a,2,3\n", "line 2: expected 5 fields");
  expect_error("1 A 255\n", "line 1: expected NUMBER NAME RED GREEN BLUE");
  expect_error("1 A 255 0\n", "line 1: expected NUMBER NAME RED GREEN BLUE");
  expect_error("1 A 255 0 0 0\n2 B\n", "line 2: expected a colour, as line 1 has");
  expect_error("1 A 0.5 0 0 0\n", "line 1: expected red, green and blue as whole numbers");
  expect_error("index,name,Name\n1,a,b\n", "line 1: expected each column once, found 'name' and 'Name'");
  expect_error("index,index\n1,2\n", "expected each column once");
  expect_error("index,name\n1,a\n2,b\n1,c\n", "line 4: label 1 has a line already, line 2");
  expect_error("1 a\n1 b\n", "line 2: label 1 has a line already, line 1");
  EXPECT_EQ(read("1 Precentral_L 1\n2 Precentral_R 2\n").value().at(2), (scene::LabelEntry{"Precentral_R"}));
  EXPECT_EQ(read("index,name,color\n1,a,\n1,a,\n").value().at(1), (scene::LabelEntry{"a"}));
}

TEST(LabelTableFile, later_lines_of_freesurfer_tables_count_with_a_warning) {
  const std::string path = temporary_path("labels.txt");
  write_file(path, "1 a 1 2 3 0\n2 b 1 2 3 0\n2 b 1 2 3 0\n1 c 4 5 6 0\n");
  std::vector<std::string> warnings;
  const auto table = read_label_table(path, &warnings).value();
  EXPECT_EQ(table.at(1), (scene::LabelEntry{"c", bytes(4, 5, 6), 1}));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings.front().find("labels.txt: line 4: label 1 has a line already, line 1"),
            std::string::npos)
      << warnings.front();
}

TEST(LabelTableFile, hostile_texts_come_back) {
  const std::string good =
      "0 Unknown 0 0 0 0\n1 \"a b\" 1 2 3 4\n    1   255    0    0        1  1  1    \"Label 1\"\n";
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string damaged = good;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x15);
    (void)read(damaged);
    (void)read(good.substr(0, i));
  }
  (void)read(std::string(100000, '"'));
  (void)read("index," + std::string(100000, ',') + "\n" + std::string(100000, '1'));
  (void)read(std::string(100000, '\t') + "\n");
}

TEST(LabelTableFile, names_of_tables_are_known) {
  for (const char* name : {"FreeSurferColorLUT.txt", "a.CSV", "b.tsv", "c.ctbl", "d.label"})
    EXPECT_TRUE(is_label_table_name(name));
  for (const char* name : {"seg.nii.gz", "a.nrrd", "scene.json", "out.gvx", ""})
    EXPECT_FALSE(is_label_table_name(name));
}

}  // namespace
}  // namespace gvx::io::test
